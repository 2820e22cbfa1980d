// Small valid files of every kind the loader reads, and ways to damage them.
#pragma once
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace irradia::test {

struct Sample {
    std::string name;     // of the file; its ending says the kind
    std::string element;  // scene file's element that reads it, with $FILE for the name
    std::string bytes;
    /// Damages the contents before they are compressed; empty: there is no inside to get at.
    std::function<std::string(const std::function<void(std::string&)>& damage)> inside{};
};

/// Written into `folder` first, those that need a library to write them.
std::vector<Sample> samples(const std::string& folder);

/// Damages `bytes` in one of several ways: cut off, bits flipped, a number or a word exchanged, bytes removed,
/// repeated.
void damage(std::string& bytes, std::mt19937& random);

}  // namespace irradia::test
