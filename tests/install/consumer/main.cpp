// consumer SCENE OUT: renders a small picture with nothing but the public headers.
#include <irradia/Accel.h>
#include <irradia/Error.h>
#include <irradia/Renderer.h>
#include <irradia/SceneLoader.h>

#include <cstdio>

int main(int, char** argv) {
    try {
        irradia::LoadOptions options;
        options.width = options.height = 16;
        irradia::Scene scene = irradia::load_scene(argv[1], options);
        irradia::build_accel(scene);
        irradia::Device device(irradia::DeviceOptions{});
        irradia::RenderSettings settings;
        settings.method = irradia::Method::path;
        settings.spp = 4;
        irradia::write_image(argv[2], irradia::render(scene, device, settings).image);
    } catch (const irradia::Error& error) {
        std::fprintf(stderr, "consumer: %s\n", error.what());
        return error.exit_status();
    }
}
