// A socket that keeps what each write(2) was: one packet each.
#pragma once
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace irradia::test {

class Packets {
public:
    Packets() {
        if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends_) != 0) throw std::runtime_error("socketpair");
    }
    ~Packets() {
        close_end();
        ::close(ends_[0]);
    }
    Packets(const Packets&) = delete;
    Packets& operator=(const Packets&) = delete;

    /// What is to be written to.
    [[nodiscard]] int end() const { return ends_[1]; }
    void close_end() {
        if (ends_[1] >= 0) ::close(ends_[1]);
        ends_[1] = -1;
    }
    /// The reader goes away.
    void close_reader() { ::shutdown(ends_[0], SHUT_RDWR); }

    /// The packets that are there; `wait`: those that come until the last writer has closed.
    std::vector<std::string> take(bool wait = false) {
        std::vector<std::string> packets;
        std::string buffer(1 << 18, '\0');
        for (;;) {
            pollfd ready{ends_[0], POLLIN, 0};
            if (!wait && ::poll(&ready, 1, 0) <= 0) return packets;
            const ssize_t bytes = ::recv(ends_[0], buffer.data(), buffer.size(), 0);
            if (bytes <= 0) return packets;
            packets.emplace_back(buffer, 0, static_cast<std::size_t>(bytes));
        }
    }

private:
    int ends_[2] = {-1, -1};
};

inline std::string joined(const std::vector<std::string>& packets) {
    std::string text;
    for (const std::string& packet : packets) text += packet;
    return text;
}

}  // namespace irradia::test
