// irradia_bench [--device SELECT] [Google Benchmark's options]
#include <benchmark/benchmark.h>

#include <cstring>
#include <exception>
#include <iostream>

#include "bench.h"

int main(int argc, char** argv) {
    irradia::DeviceOptions options;
    options.threads = 1;  // Embree is timed on one, and rates are told per thread
    options.select = "CPU";
    for (const irradia::DeviceDescription& d : irradia::list_devices())
        if (d.is_cpu) {
            options.select = std::to_string(d.index);
            break;
        }
    int kept = 1;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--device") == 0 && i + 1 < argc)
            options.select = argv[++i];
        else if (std::strncmp(argv[i], "--device=", 9) == 0)
            options.select = argv[i] + 9;
        else
            argv[kept++] = argv[i];
    }
    argc = kept;
    irradia::bench::register_rays();
    irradia::bench::register_octree(options);
    irradia::bench::register_hemispheres(options);
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    try {
        benchmark::RunSpecifiedBenchmarks();
    } catch (const std::exception& e) {
        std::cerr << "irradia_bench: " << e.what() << '\n';
        return 1;
    }
    return 0;
}
