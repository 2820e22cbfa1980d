// A 64-bit checksum against damage (not against forgery).
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace irradia {

/// Eight bytes a step, mixed as xxHash's 64-bit variant mixes a lane. A step is a bijection of h for each word and of
/// the word for each h, so any change within one word changes the result; others go unseen with probability 2^-64.
inline std::uint64_t checksum(const void* data, std::size_t bytes, std::uint64_t seed = 0) {
    constexpr std::uint64_t kPrime1 = 0x9e3779b185ebca87u, kPrime2 = 0xc2b2ae3d27d4eb4fu, kPrime3 = 0x165667b19e3779f9u;
    const auto* at = static_cast<const unsigned char*>(data);
    std::uint64_t h = seed + bytes * kPrime1 + kPrime3;
    const auto step = [&](std::uint64_t word) {
        h ^= std::rotl(word * kPrime2, 31) * kPrime1;
        h = std::rotl(h, 27) * kPrime1 + kPrime3;
    };
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
    h = (h ^ (h >> 33)) * kPrime2;
    h = (h ^ (h >> 29)) * kPrime3;
    return h ^ (h >> 32);
}

}  // namespace irradia
