// What is taken out of PoCL's binaries: its LLVM code, nothing else, and only of what is whole and known.
#include "device/pocl_binary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "device/session.h"

namespace {

using irradia::device::check;
using irradia::device::Session;
using irradia::device::without_llvm_code;
using Bytes = std::vector<unsigned char>;

constexpr std::size_t format_at = 16;

class PoclBinary : public ::testing::Test {
protected:
    void SetUp() override {
        if (session_.device.description.platform != "Portable Computing Language") GTEST_SKIP() << "needs PoCL";
        const std::string text =
            "__kernel void twice(__global uint* a) { a[get_global_id(0)] *= 2u; }\n"
            "__kernel __attribute__((reqd_work_group_size(4, 1, 1))) void thrice(__global uint* a, __local uint* b) {\n"
            "    b[get_local_id(0)] = a[get_global_id(0)];\n"
            "    barrier(CLK_LOCAL_MEM_FENCE);\n"
            "    a[get_global_id(0)] = 3u * b[get_local_id(0) ^ 1u];\n"
            "}\n";
        whole_ = compile(text);
        std::uint32_t format = 0;
        std::memcpy(&format, whole_.data() + format_at, sizeof format);
        if (format < 9 || format > 11) GTEST_SKIP() << "needs PoCL's binaries of format 9 to 11, found " << format;
    }

    [[nodiscard]] Bytes compile(const std::string& text) const {
        const char* data = text.c_str();
        const std::size_t length = text.size();
        cl_int status = CL_SUCCESS;
        cl_program program = clCreateProgramWithSource(session_.context, 1, &data, &length, &status);
        check(status, "making a program");
        check(clBuildProgram(program, 1, &session_.device.id, "-cl-std=CL1.2", nullptr, nullptr), "compiling");
        std::size_t size = 0;
        check(clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof size, &size, nullptr), "asking for a size");
        Bytes binary(size);
        unsigned char* to = binary.data();
        check(clGetProgramInfo(program, CL_PROGRAM_BINARIES, sizeof to, static_cast<void*>(&to), nullptr), "reading");
        clReleaseProgram(program);
        return binary;
    }

    /// 1 2 3 4 ... after `name` of a program made of `binary`, `groups` of `items`.
    [[nodiscard]] std::vector<std::uint32_t> run(const Bytes& binary, const char* name, std::size_t groups,
                                                 std::size_t items) const {
        const unsigned char* data = binary.data();
        const std::size_t length = binary.size(), all = groups * items;
        cl_int taken = CL_SUCCESS, status = CL_SUCCESS;
        cl_program program =
            clCreateProgramWithBinary(session_.context, 1, &session_.device.id, &length, &data, &taken, &status);
        check(status, "taking a binary");
        check(clBuildProgram(program, 1, &session_.device.id, "-cl-std=CL1.2", nullptr, nullptr), "building");
        cl_kernel kernel = clCreateKernel(program, name, &status);
        check(status, "making a kernel");
        std::vector<std::uint32_t> values(all);
        for (std::size_t i = 0; i < all; ++i) values[i] = static_cast<std::uint32_t>(i + 1);
        cl_mem memory =
            clCreateBuffer(session_.context, CL_MEM_COPY_HOST_PTR, all * sizeof values[0], values.data(), &status);
        check(status, "making a buffer");
        check(clSetKernelArg(kernel, 0, sizeof memory, &memory), "setting an argument");
        if (std::strcmp(name, "thrice") == 0)
            check(clSetKernelArg(kernel, 1, items * sizeof values[0], nullptr), "setting local memory");
        check(clEnqueueNDRangeKernel(session_.queue, kernel, 1, nullptr, &all, &items, 0, nullptr, nullptr), "running");
        check(clEnqueueReadBuffer(session_.queue, memory, CL_TRUE, 0, all * sizeof values[0], values.data(), 0, nullptr,
                                  nullptr),
              "reading");
        clReleaseMemObject(memory);
        clReleaseKernel(kernel);
        clReleaseProgram(program);
        return values;
    }

    Session session_{irradia::DeviceOptions{}};
    Bytes whole_;
};

TEST_F(PoclBinary, LosesItsLlvmCodeAndRunsInGroupsOfAnySize) {
    const auto has_code = [](const Bytes& bytes) {
        const Bytes bitcode{'B', 'C', 0xc0, 0xde};
        return std::search(bytes.begin(), bytes.end(), bitcode.begin(), bitcode.end()) != bytes.end();
    };
    ASSERT_TRUE(has_code(whole_));
    const Bytes without = without_llvm_code(whole_);
    EXPECT_FALSE(has_code(without));
    EXPECT_LT(without.size(), whole_.size());
    for (const std::size_t items : {std::size_t{1}, std::size_t{3}, std::size_t{64}, std::size_t{256}})
        for (const std::size_t groups : {std::size_t{1}, std::size_t{5}}) {
            const std::vector<std::uint32_t> values = run(without, "twice", groups, items);
            for (std::size_t i = 0; i < values.size(); ++i) ASSERT_EQ(values[i], 2 * (i + 1));
        }
    const std::vector<std::uint32_t> values = run(without, "thrice", 7, 4);
    for (std::size_t i = 0; i < values.size(); ++i) ASSERT_EQ(values[i], 3 * ((i ^ 1) + 1));
    EXPECT_EQ(without_llvm_code(without), without);  // nothing more to lose
}

TEST_F(PoclBinary, WhatIsNotWholeOrNotKnownStaysAsItIs) {
    for (std::size_t length = 0; length < whole_.size(); length += length < 256 ? 1 : 97) {
        const Bytes cut(whole_.begin(), whole_.begin() + static_cast<std::ptrdiff_t>(length));
        EXPECT_EQ(without_llvm_code(cut), cut) << length;
    }
    Bytes longer = whole_;
    longer.push_back(0);
    EXPECT_EQ(without_llvm_code(longer), longer);
    // A program with variables, of a later format: eight bytes more.
    Bytes later = whole_;
    const std::uint64_t variables = 16;
    later[format_at] = 10;
    later.insert(later.begin() + 77, reinterpret_cast<const unsigned char*>(&variables),
                 reinterpret_cast<const unsigned char*>(&variables) + sizeof variables);
    if (whole_[format_at] == 9) {
        EXPECT_EQ(without_llvm_code(later), later);
        later[77] = 0;
        EXPECT_LT(without_llvm_code(later).size(), later.size());
    }
    // Magic, format, number of kernels and files, the folder's name, sizes, the file's name.
    for (const std::size_t at : {0, 6, 16, 19, 20, 21, 32, 35, 37, 38, 39, 76, 77, 84, 85, 88, 89, 99, 100, 103})
        for (const unsigned int flip : {64u, 255u}) {
            Bytes other = whole_;
            other[at] = static_cast<unsigned char>(other[at] ^ flip);
            EXPECT_EQ(without_llvm_code(other), other) << at << " " << flip;
        }
}

}  // namespace
