// Renders with --report, and takes the page apart by Python's parser of XML.
#pragma once
#include <nlohmann/json.hpp>

#include "command.h"

namespace irradia::test {

// Python: prints what a page holds as JSON and writes each of its pictures to <id of its figure>.png.
inline const char* const page_reader = R"py(
import base64, json, sys, xml.etree.ElementTree as E
root = E.parse(sys.argv[1]).getroot()  # raises if the page is not well-formed
parents = {c: p for p in root.iter() for c in p}
every = list(root.iter())
found = {"sections": [e.get("id") for e in root.iter("section")], "pictures": {}, "faults": [],
         "h1": "".join(root.find("body/header/h1").itertext()), "title": root.findtext("head/title"),
         "text": " ".join(" ".join(e.itertext()) for e in root.find("body") if e.tag != "script"),
         "marked": ["".join(e.itertext()) for e in root.iter("tr") if e.get("class") == "marked"],
         "captions": {f.get("id"): "".join(f.find("figcaption").itertext()) for f in root.iter("figure")},
         "data": json.loads(next(e.text for e in root.iter("script") if e.get("id") == "data"))}
ids = [e.get("id") for e in every if e.get("id")]
if len(ids) != len(set(ids)): found["faults"].append("an id is used twice")
for e in every:
    for key in ("src", "href", "action", "data"):
        if e.get(key) and not e.get(key).startswith("data:image/png;base64,"): found["faults"].append(key + " " + e.get(key))
    if e.get("aria-labelledby") and e.get("aria-labelledby") not in ids: found["faults"].append("no such label")
    if e.tag in ("link", "iframe", "object", "embed"): found["faults"].append(e.tag)
    if e.tag == "svg" and not (e.get("role") == "img" and e.get("aria-label")): found["faults"].append("svg without label")
    if e.tag == "img":
        if not e.get("alt"): found["faults"].append("img without alt")
        name = parents[e].get("id")
        png = base64.b64decode(e.get("src").split(",")[1], validate=True)
        open(name + ".png", "wb").write(png)
        found["pictures"][name] = [int(e.get("width")), int(e.get("height"))]
for word in ("http:", "https:", "@import", "url(//"):
    if word in open(sys.argv[1], encoding="utf-8").read(): found["faults"].append("contains " + word)
print(json.dumps(found))
)py";

class ReportTest : public CommandTest {
protected:
    static constexpr int size = 48;
    /// The Cornell box, small and rough.
    Outcome render(std::vector<std::string> arguments,
                   const std::string& scene = std::string(IRRADIA_SOURCE_DIR) + "/scenes/cornell-box.xml") const {
        arguments.insert(arguments.begin(),
                         {scene, "--spp", "4", "--width", std::to_string(size), "--height", std::to_string(size),
                          "--hemisphere", "4x16", "--grid-paths", "1024", "-q"});
        return call(RENDER, arguments);
    }
    /// What the page holds.
    nlohmann::json read_page(const std::string& name) const {
        const Outcome outcome = call("python3", {"-c", page_reader, name});
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return outcome.status == 0 ? nlohmann::json::parse(outcome.out) : nlohmann::json();
    }
};

}  // namespace irradia::test
