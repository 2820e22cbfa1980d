"""What a study renders: sweeps of named series of points, and the order in which their runs are made."""
import dataclasses
import hashlib
import json
import pathlib
import shlex
import xml.etree.ElementTree as ET

from . import BadInput

DEFAULTS = pathlib.Path(__file__).with_name("sweeps.json")
GLOSSY = ("roughconductor", "roughplastic")  # what --method radiance caches
KEYS = {"name", "options", "points", "vary", "values", "needs"}
MANAGED = ("-o", "--output", "--seed", "--stats", "--threads", "--device", "--width", "--height", "-D", "--define",
           "--pack", "-q", "--quiet", "-v", "--verbose", "--list-devices", "-h", "--help")


@dataclasses.dataclass(frozen=True)
class Point:
    series: str
    method: str     # of ours; of a peer its name
    peer: str       # "" for ours, else "mitsuba", "mitsuba+oidn" or "radiance"
    label: str      # what sets it apart from its series' other points
    options: tuple  # of ours: command line; of a peer: what it is told

    def option(self, name):
        """Value of one of our options, None if it is not given."""
        found = [b for a, b in zip(self.options, self.options[1:]) if a == name]
        return found[-1] if found and not self.peer else None


def words(value, where):
    if isinstance(value, str):
        return shlex.split(value)
    if isinstance(value, list) and all(isinstance(x, (str, int, float)) and not isinstance(x, bool) for x in value):
        return [str(x) for x in value]
    raise BadInput(f"{where}: {json.dumps(value)} was found, a string or a list of options was expected")


def load(name_or_file):
    """(name, {"about", "series"}) of a sweep that comes along, or of a file."""
    known = json.loads(DEFAULTS.read_text())
    if name_or_file in known:
        return name_or_file, known[name_or_file]
    path = pathlib.Path(name_or_file)
    if not path.suffix and not path.exists():
        raise BadInput(f"--sweep {name_or_file}: no such sweep and no such file; expected {', '.join(known)} or a JSON "
                       "file")
    try:
        found = json.loads(path.read_text())
    except OSError as error:
        raise BadInput(f"{path}: {error.strerror}, a JSON file with a sweep was expected") from None
    except ValueError as error:  # broken JSON, or no UTF-8
        raise BadInput(f"{path}: {error}, a JSON file with a sweep was expected") from None
    if not isinstance(found, dict) or not isinstance(found.get("series"), list) or not found["series"]:
        raise BadInput(f'{path}: an object with a list "series" was expected (tools/study --help shows one)')
    return path.stem, found


def points_of(sweep, where, glossy):
    """[[Point of a series, ...], ...]; series that need glossy surfaces only if the scene has some."""
    series, names = [], set()
    for i, s in enumerate(sweep["series"]):
        if not isinstance(s, dict) or not isinstance(s.get("name"), str) or not s["name"]:
            raise BadInput(f'{where}: series {i + 1}: an object with a "name" was expected')
        at = f"{where}: series {s['name']}"
        if s["name"] in names:
            raise BadInput(f"{at}: the name was found twice, names of their own were expected")
        names.add(s["name"])
        if set(s) - KEYS:
            raise BadInput(f"{at}: '{sorted(set(s) - KEYS)[0]}' was found, {', '.join(sorted(KEYS))} were expected")
        if s.get("needs") not in (None, "glossy"):
            raise BadInput(f"{at}: needs '{s['needs']}' was found, 'glossy' was expected")
        fixed = words(s.get("options", ""), at)
        if "points" in s and "vary" not in s and isinstance(s["points"], list):
            varied = [words(p, at) for p in s["points"]]
        elif isinstance(s.get("vary"), str) and isinstance(s.get("values"), list) and "points" not in s:
            varied = [[s["vary"], str(v)] for v in s["values"]]
        else:
            raise BadInput(f'{at}: a list "points", or "vary" (an option) and "values" (a list) were expected')
        if not varied:
            raise BadInput(f"{at}: no points were found, one at least was expected")
        for own in varied:
            for word in fixed + own:
                if word.split("=")[0] in MANAGED:
                    raise BadInput(f"{at}: {word} was found, which tools/study itself sets")
        if s.get("needs") == "glossy" and not glossy:
            continue
        line = []
        for own in varied:
            p = Point(s["name"], "irradiance", "", " ".join(own).replace("--", ""), tuple(fixed + own))
            line.append(dataclasses.replace(p, method=p.option("--method") or "irradiance"))
        series.append(line)
    return series


def in_turn(series, seeds):
    """(point, seed): seeds outermost, then the series by turns, so that a machine that slows down slows all alike."""
    longest = max((len(s) for s in series), default=0)
    for seed in seeds:
        for i in range(longest):
            for s in series:
                if i < len(s) and (s[i].peer != "radiance" or seed == seeds[0]):  # Radiance has no seed
                    yield s[i], seed


class SceneFiles:
    """A scene file and all that it names: a hash of their contents, and whether there are glossy surfaces."""

    def __init__(self, scene):
        self.digest, self.glossy, self._seen = hashlib.sha256(), False, set()
        self._xml(pathlib.Path(scene))
        self.hash = self.digest.hexdigest()[:16]

    def _bytes(self, path):
        try:
            data = path.read_bytes()
        except OSError as error:
            raise BadInput(f"{path}: {error.strerror}, a file that can be read was expected") from None
        self.digest.update(f"{len(data)} ".encode() + data)
        return data

    def _xml(self, path):
        if path.resolve() in self._seen:
            return
        self._seen.add(path.resolve())
        try:
            root = ET.fromstring(self._bytes(path))
        except ET.ParseError as error:
            raise BadInput(f"{path}:{error.position[0]}: {error}, a Mitsuba 3 scene was expected") from None
        defaults = {d.get("name"): d.get("value", "") for d in root.iter("default")}
        self.glossy |= any(b.get("type") in GLOSSY for b in root.iter("bsdf"))
        for node in root.iter():
            name = node.get("filename") if node.tag == "include" else \
                node.get("value") if node.tag == "string" and node.get("name") == "filename" else None
            if name:
                for key in sorted(defaults, key=len, reverse=True):
                    name = name.replace("$" + key, defaults[key])
                other = path.parent / name
                if node.tag == "include":
                    self._xml(other)
                elif other.is_file() and other.resolve() not in self._seen:  # if not, render will say so
                    self._seen.add(other.resolve())
                    self._bytes(other)
