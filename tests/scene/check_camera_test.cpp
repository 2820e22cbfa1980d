// Cameras inside solid objects and right before surfaces are errors; cameras in rooms are not.
#include "scene_test.h"

namespace irradia::test {
namespace {

class CheckCamera : public SceneTest {
protected:
    /// A camera at `origin` that looks along `forward`, and one shape with an id.
    static std::string view(const std::string& origin, const std::string& target, const std::string& more = "") {
        return "<sensor type=\"perspective\"><float name=\"fov\" value=\"60\"/>" + more +
               "<transform name=\"to_world\"><lookat origin=\"" + origin + "\" target=\"" + target +
               "\" up=\"0, 1, 0\"/></transform></sensor>\n";
    }
    static std::string shape(const std::string& type, const std::string& inside = "") {
        return "<shape type=\"" + type + "\" id=\"thing\">" + inside + "</shape>\n";
    }
    /// Far away, out of all views.
    static std::string distant_lamp() {
        return "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"100\" z=\"0\"/></emitter>\n";
    }
    static std::string inward() { return "<boolean name=\"flip_normals\" value=\"true\"/>"; }
    static std::string twosided() { return "<bsdf type=\"twosided\"><bsdf type=\"diffuse\"/></bsdf>"; }
    static std::string moved(const std::string& operation) {
        return "<transform name=\"to_world\">" + operation + "</transform>";
    }
};

TEST_F(CheckCamera, InsideASolidIsAnError) {
    const std::string camera = view("0.1, 0, 0", "0.1, 0, 1");
    for (const char* type : {"cube", "sphere"})
        expect_message(
            error(camera + shape(type) + distant_lamp()),
            {"scene.xml:2: ", "camera at (0.1, 0, 0) is inside", "id=\"thing\"", "scene.xml:3)", "twosided"});
    write("t.ply", tetrahedron);
    expect_message(error(view("0.2, 0.2, 0.2", "1, 0.2, 0.2") +
                         shape("ply", "<string name=\"filename\" value=\"t.ply\"/>") + distant_lamp()),
                   {"is inside <shape type=\"ply\" id=\"thing\">"});
    // What is outside does not help, nor does an environment that cannot be seen.
    expect_message(error(camera + shape("cube") + "<shape type=\"rectangle\">" + moved("<translate z=\"5\"/>") +
                         "<emitter type=\"area\"/></shape><emitter type=\"constant\"/>"),
                   {"is inside <shape type=\"cube\" id=\"thing\">"});
}

TEST_F(CheckCamera, ACylinderIsNoSolidAlongItsAxis) {
    const std::string tube = shape("cylinder", moved("<translate z=\"-.5\"/><scale z=\"1000\"/>")) + distant_lamp();
    // Across it sees the inner side alone; from the ends, open, there is too little to see.
    expect_message(error(view("0.1, 0, 0", "1, 0, 0.1") + tube), {"is inside <shape type=\"cylinder\""});
    EXPECT_NO_THROW(load(view("3, 0, 0", "0, 0, 0") + tube));
    EXPECT_NO_THROW(load(view("0.1, 0, 0", "1, 0, 0.1") +
                         shape("cylinder", inward() + moved("<translate z=\"-.5\"/>")) + distant_lamp()));
}

TEST_F(CheckCamera, TheObjectAroundTheCameraIsNamed) {
    const std::string message = error(view("0, 0, 0", "0, 0, 1") + "<shape type=\"sphere\" id=\"outer\">" +
                                      moved("<scale value=\"5\"/>") + "</shape>" + shape("cube") + distant_lamp());
    expect_message(message, {"is inside <shape type=\"cube\" id=\"thing\">"});
}

TEST_F(CheckCamera, ARoomIsNoSolid) {
    const std::string camera = view("0.1, 0, 0", "0.1, 0, 1");
    EXPECT_NO_THROW(load(camera + shape("cube", inward()) + distant_lamp()));
    EXPECT_NO_THROW(load(camera + shape("sphere", inward()) + distant_lamp()));
    EXPECT_NO_THROW(load(camera + shape("cube", twosided()) + distant_lamp()));
    // A solid with a window in view.
    write("open.obj", "v -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\nv 0 0 -1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
    const std::string open = shape("obj", "<string name=\"filename\" value=\"open.obj\"/>") + distant_lamp();
    EXPECT_NO_THROW(load(view("0, 0, 0", "0, 0, 1") + open));
    // Seen through the open side of a one-sided box, whose other walls show their backs to the outside.
    EXPECT_NO_THROW(load(view("0, 0, 4", "0, 0, 1") + open));
}

TEST_F(CheckCamera, OutsideASolidThatFillsTheFilmIsFine) {
    EXPECT_NO_THROW(load(view("0, 0, 1.1", "0, 0, 0") + shape("cube") + distant_lamp()));
    // Black, but not inside: a one-sided room from outside.
    EXPECT_NO_THROW(load(view("0, 0, 1.1", "0, 0, 0") + shape("cube", inward()) + distant_lamp()));
}

TEST_F(CheckCamera, ASurfaceWithinNearClipThatHidesAllIsAnError) {
    // On the rectangle, and a hair before and behind it, with nothing beyond.
    for (const char* z : {"0", "0.005", "-0.005"}) {
        const std::string origin = std::string("0.1, 0, ") + z;
        expect_message(error(view(origin, z[0] == '-' ? "0.1, 0, 1" : "0.1, 0, -1") +
                             shape("rectangle", moved("<scale value=\"9\"/>")) + distant_lamp()),
                       {"scene.xml:2: ", "camera at (0.1, 0, " + std::string(z) + ") lies within near_clip (0.01)",
                        "<shape type=\"rectangle\" id=\"thing\"> ", "scene.xml:3)"});
    }
    expect_message(error(view("0, 0, 0.002", "0, 0, 0") + shape("disk") + distant_lamp()), {"near_clip", "disk"});
}

TEST_F(CheckCamera, NearClipMayCutAWallAway) {
    const std::string wall = shape("rectangle", moved("<scale value=\"9\"/>")) + distant_lamp();
    // Something is seen beyond the wall: a floor, or the sky.
    const std::string floor =
        "<shape type=\"rectangle\">" + moved("<scale value=\"50\"/><translate z=\"-3\"/>") + "</shape>";
    EXPECT_NO_THROW(load(view("0, 0, 0.005", "0, 0, -1") + wall + floor));
    EXPECT_NO_THROW(load(view("0, 0, 0.005", "0, 0, -1") + wall + "<emitter type=\"constant\"/>"));
    // The wall is not in the way of a camera that stands on it and looks into the room.
    EXPECT_NO_THROW(load(view("0, 0, -1", "0, 0, 0") + shape("cube", inward()) + distant_lamp()));
    // A smaller near_clip shows the wall itself.
    EXPECT_NO_THROW(load(view("0, 0, 0.005", "0, 0, -1", "<float name=\"near_clip\" value=\"0.001\"/>") + wall));
}

}  // namespace
}  // namespace irradia::test
