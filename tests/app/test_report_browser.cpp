// render --report in a browser without a window: what is really seen.
#include "image/image_check.h"
#include "report_command.h"

namespace irradia {
namespace {

class ReportBrowser : public test::ReportTest {
protected:
    void SetUp() override {
        ReportTest::SetUp();
        if (std::system("command -v chromium >/dev/null 2>&1") == 0) return;
        const char* const what = "no chromium (Debian: chromium), which shows the pages of render --report";
        if (const char* ci = std::getenv("IRRADIA_CI"); ci != nullptr && *ci != '\0') FAIL() << what;
        GTEST_SKIP() << what;
    }
    test::Outcome browse(const std::string& page, std::vector<std::string> arguments) const {
        arguments.insert(
            arguments.begin(),
            {"--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
             "--force-color-profile=srgb", "--user-data-dir=" + in_folder("profile"), "--virtual-time-budget=5000"});
        std::string address = "file://" + in_folder(page);  // the folder's name has blanks
        for (std::size_t at = 0; (at = address.find(' ', at)) != std::string::npos;) address.replace(at, 1, "%20");
        arguments.push_back(address);
        const test::Outcome outcome = call("chromium", arguments);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return outcome;
    }
    /// A page that shows another in a frame of that size, with `script` at its end: a window's inner size is not the
    /// one asked for. What the script says (by `say(text)`) becomes the title.
    void put_in_frame(const std::string& page, int width, int height, const std::string& script) const {
        std::string text = test::file_text(in_folder(page));
        const std::size_t end = text.rfind("</body>");
        ASSERT_NE(end, std::string::npos);
        text.insert(end, "<script>function say(text) { parent.postMessage(text, '*'); }" + script + "</script>");
        std::ofstream(in_folder("inner.html")) << text;
        std::ofstream(in_folder("frame.html"))
            << "<!DOCTYPE html><title>nothing was said</title><body style='margin: 0'><script>"
               "addEventListener('message', e => { document.title = e.data; });</script>"
               "<iframe src='inner.html' style='border: 0; display: block' width='"
            << width << "' height='" << height << "'></iframe></body>";
    }
    std::string said_in_frame() const {
        const std::string dom = browse("frame.html", {"--window-size=1200,1500", "--dump-dom"}).out;
        const std::size_t begin = dom.find("<title>"), end = dom.find("</title>");
        if (begin == std::string::npos || end == std::string::npos) return dom;
        return dom.substr(begin + 7, end - begin - 7);
    }
    Image screenshot(const std::string& page, const std::string& window, std::vector<std::string> more = {}) const {
        std::filesystem::remove(in_folder("shot.png"));
        more.insert(more.end(), {"--window-size=" + window, "--screenshot=" + in_folder("shot.png")});
        browse(page, more);
        return read_image(in_folder("shot.png"));
    }
    static int byte_at(const Image& image, int x, int y, int c) {
        const Layer& layer = image.layers.front();
        const std::size_t at =
            (static_cast<std::size_t>(y) * image.width + x) * static_cast<std::size_t>(layer.channels);
        return static_cast<int>(std::lround(255 * srgb_encode(layer.data[at + c])));
    }
};

TEST_F(ReportBrowser, ShowsThePicture) {
    ASSERT_EQ(render({"-o", "a.png", "--exposure", "1", "--report", "a.html"}).status, 0);
    put_in_frame("a.html", 1000, 1400,
                 "var b = document.getElementById('viewed').getBoundingClientRect();"
                 "say([b.left, b.top, b.width, b.height].join(' '));");
    double left = 0, top = 0, width = 0, height = 0;
    const std::string where = said_in_frame();
    ASSERT_EQ(std::sscanf(where.c_str(), "%lf %lf %lf %lf", &left, &top, &width, &height), 4) << where;
    EXPECT_GT(width, 400);
    EXPECT_NEAR(height, width, 1);  // the picture is square
    // Small pictures are shown enlarged without smoothing: the middle of each pixel has its colour.
    const Image shot = screenshot("frame.html", "1200,1500"), picture = read_image(in_folder("a.png"));
    ASSERT_EQ(shot.width, 1200);
    ASSERT_GE(shot.height, static_cast<int>(top + height));
    int wrong = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const int sx = static_cast<int>(left + (x + 0.5) * width / size);
            const int sy = static_cast<int>(top + (y + 0.5) * height / size);
            for (int c = 0; c < 3; ++c)
                if (std::abs(byte_at(shot, sx, sy, c) - byte_at(picture, x, y, c)) > 1) ++wrong;
        }
    EXPECT_EQ(wrong, 0) << "of " << 3 * size * size;
}

TEST_F(ReportBrowser, ZoomsMovesAndShowsTheOtherPictures) {
    ASSERT_EQ(render({"-o", "a.pfm", "--report", "a.html"}).status, 0);
    put_in_frame("a.html", 1000, 1400,
                 "var v = document.getElementById('viewer'), i = document.getElementById('viewed'), said = [];"
                 "function now() { said.push(i.style.transform.replace(/[^0-9.-]+/g, ' ').trim()); }"
                 "function at(x, y) { var b = v.getBoundingClientRect();"
                 "  return { clientX: b.left + x * b.width, clientY: b.top + y * b.height, cancelable: true }; }"
                 "v.setPointerCapture = function () {};"  // there is no real pointer
                 "function pointer(name, x, y) {"
                 "  v.dispatchEvent(new PointerEvent(name, Object.assign({ pointerId: 1 }, at(x, y)))); }"
                 "now();"
                 "v.dispatchEvent(new WheelEvent('wheel', Object.assign({ deltaY: -200 }, at(0.5, 0.5)))); now();"
                 "pointer('pointerdown', 0.5, 0.5); pointer('pointermove', 0.5, 0.5);"
                 "pointer('pointermove', 0.6, 0.5); pointer('pointerup', 0.6, 0.5); now();"
                 "v.dispatchEvent(new KeyboardEvent('keydown', { key: '0' })); now();"
                 "Array.from(document.querySelectorAll('.tools button')).find(b => b.textContent === 'Depth').click();"
                 "said.push(i.src === document.querySelector('#layer-depth img').src, v.clientWidth);"
                 "say(said.join(';'));");
    const std::string said = said_in_frame();
    double x[4], y[4], zoom[4], width = 0;
    char depth[8] = "";
    ASSERT_EQ(
        std::sscanf(said.c_str(), "%lf %lf %lf;%lf %lf %lf;%lf %lf %lf;%lf %lf %lf;%7[a-z];%lf", &x[0], &y[0], &zoom[0],
                    &x[1], &y[1], &zoom[1], &x[2], &y[2], &zoom[2], &x[3], &y[3], &zoom[3], depth, &width),
        14)
        << said;
    EXPECT_EQ(zoom[0], 1);
    EXPECT_GT(zoom[1], 1.5);
    EXPECT_NEAR(x[1], width / 2 * (1 - zoom[1]), 2);  // what was in the middle still is
    EXPECT_NEAR(x[2] - x[1], 0.1 * width, 2);         // moved as far as the pointer
    EXPECT_NEAR(y[2], y[1], 0.01);
    EXPECT_EQ(zoom[3], 1);
    EXPECT_EQ(x[3], 0);
    EXPECT_STREQ(depth, "true");
}

TEST_F(ReportBrowser, HasALightAndADarkScheme) {
    ASSERT_EQ(render({"-o", "a.pfm", "--report", "a.html"}).status, 0);
    EXPECT_GT(byte_at(screenshot("a.html", "800,600"), 3, 3, 1), 200);
    EXPECT_LT(byte_at(screenshot("a.html", "800,600", {"--blink-settings=preferredColorScheme=0"}), 3, 3, 1), 60);
}

// A window is never as narrow as a phone, a frame is.
TEST_F(ReportBrowser, FitsAPhone) {
    const std::string scene = "a-name-that-has-no-place-to-be-broken-" + std::string(80, 'x') + ".xml";
    std::filesystem::copy_file(std::string(IRRADIA_SOURCE_DIR) + "/scenes/cornell-box.xml", in_folder(scene));
    ASSERT_EQ(render({"-o", "ref.pfm", "--seed", "5"}).status, 0);
    ASSERT_EQ(render({"-o", "a.pfm", "--report", "a.html", "--report-error", "--reference", "ref.pfm"}, scene).status,
              0);
    put_in_frame("a.html", 400, 3000,
                 "var widest = 0;"
                 "document.querySelectorAll('main img, main svg, main table, h1, header p').forEach(function (e) {"
                 "  if (e.id === 'viewed') return; widest = Math.max(widest, e.getBoundingClientRect().right); });"
                 "say([innerWidth, document.documentElement.scrollWidth, Math.ceil(widest),"
                 "  document.querySelectorAll('.tools button').length].join(' '));");
    int window = 0, page = 0, widest = 0, buttons = 0;
    const std::string title = said_in_frame();
    ASSERT_EQ(std::sscanf(title.c_str(), "%d %d %d %d", &window, &page, &widest, &buttons), 4) << title;
    EXPECT_EQ(window, 400);
    EXPECT_EQ(page, 400);
    EXPECT_LE(widest, 400);
    EXPECT_EQ(buttons, 1 + 7 + 1 + 2 + 4);  // picture, layers, records, error map and reference, zoom: the script ran
}

}  // namespace
}  // namespace irradia
