#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "gl/device.h"

namespace fumarole::gl {

/// What makes a variant of a shader: values of constants that its files declare, as
/// `const bool kName = false;` (names that begin with k and a capital), macros for what a constant
/// can't be, a type or a binding, ahead of the source, and files that are written for a scene.
class Defines {
public:
    using Entry = std::pair<std::string, std::string>;

    Defines() = default;
    Defines(std::initializer_list<Entry> entries)
    {
        for (const Entry& entry : entries)
            emplace_back(entry.first, entry.second);
    }

    /// A constant or a macro; a later value of the same name takes the place of an earlier one. A
    /// constant's value "" is true. One that reads a uniform (u_...) makes a macro of the constant.
    void emplace_back(std::string name, std::string value);
    /// A file that an `#include` of its name finds, rather than the one of glsl/:
    /// written/media.glsl.
    void add_file(const std::string& name, std::string text) { files_[name] = std::move(text); }
    Defines& operator+=(const Defines& other);

    [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
    [[nodiscard]] const std::string* value_of(std::string_view name) const;
    [[nodiscard]] const std::string* file(const std::string& name) const;
    [[nodiscard]] static bool is_constant(std::string_view name)
    {
        return name.size() > 1 && name[0] == 'k' && name[1] >= 'A' && name[1] <= 'Z';
    }
    // NOLINTNEXTLINE(modernize-use-nullptr): the 0 is in what the compiler makes of this.
    auto operator<=>(const Defines&) const = default;

private:
    std::vector<Entry> entries_;
    std::map<std::string, std::string> files_;
};

/// A source with its includes put in, and where each of its lines came from.
struct ExpandedSource {
    std::string text;
    std::vector<std::pair<std::string, int>> origin;  ///< file and line of each line of text

    /// A driver's log with its line numbers turned into `file:line`, and the lines of files that
    /// are written for a scene, which nobody can look up, beside them.
    [[nodiscard]] std::string map_log(std::string_view log) const;
};

/// Expands a file of glsl/ (`pass/ray_march.frag`): the version line, the macros, then the file
/// with each `#include "..."` put in once, however often it is named, and the constants' values in
/// place of those that it declares them with. A written/ file that the variant has not is an
/// #error line.
/// @throws Error if another file is not there, or no file declares a constant.
ExpandedSource expand_shader(std::string_view file, const Defines& defines);

/// The same for a text that is in no file; `name` stands for it in messages.
ExpandedSource expand_text(std::string_view name, std::string_view text, const Defines& defines);

/// All shader files by name, as built into the library.
const std::map<std::string, std::string_view, std::less<>>& shader_files();

class Program {
public:
    Program() = default;
    /// A vertex and a fragment file, or one compute file.
    /// @throws Error with the driver's log, its lines mapped to our files.
    Program(const Device& device, const std::vector<std::string>& files, const Defines& defines);
    /// One compute shader, expanded already; `name` stands for it in messages.
    static Program compute(const Device& device, std::string_view name,
                           const ExpandedSource& source);

    [[nodiscard]] GLuint id() const { return handle_.id(); }

private:
    static void destroy(const Device& gl, GLuint id) { gl->DeleteProgram(id); }
    /// Compiles and links, or takes what is kept of an earlier run (Device::programs()).
    void build(const std::vector<std::string>& files, const std::vector<ExpandedSource>& sources);
    void link(std::string_view name, const std::vector<GLuint>& shaders) const;
    Handle<&Program::destroy> handle_;
};

/// Programs by their files and defines, each compiled once.
class ProgramCache {
public:
    explicit ProgramCache(const Device& device) : device_{device} {}
    const Program& get(const std::vector<std::string>& files, const Defines& defines);

private:
    const Device& device_;
    std::map<std::pair<std::vector<std::string>, Defines>, Program> programs_;
};

}  // namespace fumarole::gl
