// How options are declared, and checks of their values.
#pragma once
#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "app/options.h"

namespace irradia::app {

/// As streams print it: 0.2, not 0.200000.
std::string option_text(double value);
std::string join(const std::vector<std::string>& parts, const char* between);

/// Adds options to one group of --help.
class Group {
public:
    Group(CLI::App& app, std::string name) : app_(app), name_(std::move(name)) {}

    template <class T>
    CLI::Option* value(const std::string& names, T& target, const std::string& unit, const std::string& help) {
        return app_.add_option(names, target, help)->type_name(unit)->group(name_);
    }

    /// May be given several times, with one value each.
    CLI::Option* list(const std::string& names, std::vector<std::string>& target, const std::string& unit,
                      const std::string& help) {
        return value(names, target, unit, help)->allow_extra_args(false);
    }

    template <class E>
    CLI::Option* choice(const std::string& names, E& target, const Names<E>& values, const std::string& help) {
        return chosen<E>(
                   names, [&target](E v) { target = v; }, values, help)
            ->default_str(name_of(values, target));
    }

    /// Hands the value chosen to `take`.
    template <class E>
    CLI::Option* chosen(const std::string& names, const std::function<void(E)>& take, const Names<E>& values,
                        const std::string& help) {
        std::vector<std::string> words;
        for (const auto& [v, word] : values) words.push_back(word);
        const std::string all = join(words, "|");
        const auto check = [words, all](const std::string& given) {
            return std::find(words.begin(), words.end(), given) != words.end() ? std::string()
                                                                               : "'" + given + "' is not one of " + all;
        };
        const auto set = [take, &values](const std::string& given) {
            for (const auto& [v, word] : values)
                if (word == given) take(v);
        };
        return app_.add_option_function<std::string>(names, set, help)->check(check)->type_name(all)->group(name_);
    }

    CLI::Option* flag(const std::string& names, bool& target, const std::string& help) {
        return app_.add_flag(names, target, help)->group(name_);
    }

    /// `--no-x`: clears `target`, which is on by default.
    CLI::Option* off(const std::string& name, bool& target, const std::string& help) {
        return app_
            .add_flag_callback(
                name, [&target] { target = false; }, help)
            ->group(name_);
    }

private:
    CLI::App& app_;
    std::string name_;
};

/// A check of one number; CLI11's own let "nan" pass.
std::function<std::string(const std::string&)> number(const std::string& what, const std::function<bool(double)>& good);

}  // namespace irradia::app
