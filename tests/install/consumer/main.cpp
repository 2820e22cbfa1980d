// consumer SCENE OUT [RECORDS]: renders a small picture, and keeps its records, with nothing but the public headers.
#include <irradia/Accel.h>
#include <irradia/Error.h>
#include <irradia/RecordFile.h>
#include <irradia/Renderer.h>
#include <irradia/SceneLoader.h>

#include <cstdio>

int main(int argc, char** argv) {
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
        if (argc < 4) return 0;
        settings.method = irradia::Method::irradiance;
        irradia::RecordSet records;
        irradia::render(scene, device, settings, {}, &records);
        irradia::write_records(argv[3], records);
        return irradia::read_records(argv[3]).irradiance.size() == records.irradiance.size() ? 0 : 1;
    } catch (const irradia::Error& error) {
        std::fprintf(stderr, "consumer: %s\n", error.what());
        return error.exit_status();
    }
}
