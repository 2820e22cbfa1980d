// The state of a render that has been interrupted: a file that the same program, given the same input, goes on from.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace irradia {

class AsideFile;

/// What a state belongs to, by name: it is of use only where all of it is the same.
using CheckpointIdentity = std::vector<std::pair<std::string, std::string>>;

/// A checkpoint being written, or being read. Objects exchange their state with it in one function for both: it writes
/// what it is given, or replaces it by what it has read, in the same order.
///
/// Bytes are those of this machine; a checksum covers all of them. Written beside `path`, synchronised and renamed, so
/// that the file is always whole.
class Checkpoint {
public:
    static Checkpoint write(const std::string& path, const CheckpointIdentity& identity);
    /// Throws Error, one line: unreadable, no checkpoint, of another version, damaged, or of something else than
    /// `identity`, with what differs.
    static Checkpoint read(const std::string& path, const CheckpointIdentity& identity);
    Checkpoint(Checkpoint&&) noexcept;
    ~Checkpoint();

    [[nodiscard]] bool reading() const noexcept;

    template <class T>
    Checkpoint& operator()(T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        bytes(&value, sizeof value);
        return *this;
    }
    Checkpoint& operator()(std::string& text);
    template <class T, class Allocator>
    Checkpoint& operator()(std::vector<T, Allocator>& values) {
        const std::uint64_t n = count(values.size(), std::is_trivially_copyable_v<T> ? sizeof(T) : 1);
        if (reading()) values.resize(n);
        if constexpr (std::is_trivially_copyable_v<T>)
            bytes(values.data(), n * sizeof(T));
        else
            for (T& value : values) (*this)(value);
        return *this;
    }
    template <class K, class V>
    Checkpoint& operator()(std::map<K, V>& values) {
        std::vector<K> keys;
        for (const auto& [key, value] : values) keys.push_back(key);
        (*this)(keys);
        if (reading()) values.clear();
        for (const K& key : keys) (*this)(values[key]);
        return *this;
    }
    /// Is there a value? Then it is to be exchanged next; when reading, `make` has made one.
    template <class T, class Make>
    bool has(std::optional<T>& value, const Make& make) {
        std::uint8_t there = value.has_value();
        (*this)(there);
        if (reading()) {
            value.reset();
            if (there != 0) make();
        }
        return there != 0;
    }
    void bytes(void* data, std::uint64_t size);

    /// Writing: the file takes the place of an older one. Reading: throws Error if anything is left.
    void finish();

private:
    struct Impl;
    explicit Checkpoint(std::unique_ptr<Impl> impl);
    /// Of elements that follow, `size` bytes each at least.
    std::uint64_t count(std::uint64_t n, std::uint64_t size);
    std::unique_ptr<Impl> impl_;
};

}  // namespace irradia
