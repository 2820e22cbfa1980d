// Runs an executable and keeps what it says.
#pragma once
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "../image/pictures.h"

namespace irradia::test {

struct Outcome {
    int status = -1;  ///< exit status; 128 + signal if it was killed
    std::string out, err;
};

inline std::string quoted(const std::string& word) {
    std::string out = "'";
    for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

inline std::string file_text(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

/// A test that calls executables; what they write to stdout and stderr lies beside its folder.
class CommandTest : public InFolder {
protected:
    Outcome call(const std::string& executable, const std::vector<std::string>& arguments) const {
        const std::string out = folder_.string() + ".out", err = folder_.string() + ".err";
        std::string line = "cd " + quoted(folder_.string()) + " && " + quoted(executable);
        for (const std::string& argument : arguments) line += " " + quoted(argument);
        const int status = std::system((line + " >" + quoted(out) + " 2>" + quoted(err) + " </dev/null").c_str());
        Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), file_text(out),
                        file_text(err)};
        std::filesystem::remove(out);
        std::filesystem::remove(err);
        return outcome;
    }

    /// `status`, nothing on stdout, and one line on stderr that begins with the program's name and contains `what`.
    static void expect_one_line(const Outcome& outcome, int status, const std::string& program,
                                const std::string& what) {
        EXPECT_EQ(outcome.status, status) << outcome.err;
        EXPECT_EQ(outcome.out, "");
        EXPECT_EQ(outcome.err.rfind(program + ": ", 0), 0u) << outcome.err;
        EXPECT_EQ(outcome.err.find('\n'), outcome.err.size() - 1) << outcome.err;
        EXPECT_NE(outcome.err.find(what), std::string::npos) << outcome.err;
    }
};

/// Options ("--spp") in the order in which they stand in `text`, without repeats.
inline std::vector<std::string> options_in(const std::string& text) {
    std::vector<std::string> options;
    for (std::size_t at = text.find("--"); at != std::string::npos; at = text.find("--", at)) {
        std::size_t end = at + 2;
        while (end < text.size() && (std::islower(static_cast<unsigned char>(text[end])) || text[end] == '-')) ++end;
        const std::string option = text.substr(at, end - at);
        const bool begins = at == 0 || text[at - 1] != '-';
        if (begins && option.size() > 2 && option[2] != '-' &&
            std::find(options.begin(), options.end(), option) == options.end())
            options.push_back(option);
        at = end;
    }
    return options;
}

}  // namespace irradia::test
