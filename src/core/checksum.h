// A 64-bit checksum against damage (not against forgery).
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace irradia {

/// Eight bytes a step: h = rotate(h ^ word, 29) * odd, a bijection of h for each word and of the word for each h. So
/// any change within one word changes the result; others go unseen with probability 2^-64.
inline std::uint64_t checksum(const void* data, std::size_t bytes, std::uint64_t seed = 0) {
    constexpr std::uint64_t kPrime = 0x9e3779b97f4a7c15u;  // 2^64 / golden ratio, odd
    const auto* at = static_cast<const unsigned char*>(data);
    std::uint64_t h = (seed ^ bytes) * kPrime + 0x632be59bd9b4e019u;
    const auto step = [&](std::uint64_t word) { h = std::rotl(h ^ word, 29) * kPrime; };
    for (; bytes >= 8; bytes -= 8, at += 8) {
        std::uint64_t word;
        std::memcpy(&word, at, 8);
        step(word);
    }
    if (bytes > 0) {
        std::uint64_t word = 0;
        std::memcpy(&word, at, bytes);
        step(word);
    }
    h = (h ^ (h >> 32)) * kPrime;
    return h ^ (h >> 29);
}

}  // namespace irradia
