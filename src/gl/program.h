#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "gl/device.h"

namespace fumarole::gl {

/// `#define name value` lines ahead of the source: what makes a variant.
using Defines = std::vector<std::pair<std::string, std::string>>;

/// A source with its includes put in, and where each of its lines came from.
struct ExpandedSource {
    std::string text;
    std::vector<std::pair<std::string, int>> origin;  ///< file and line of each line of text

    /// A driver's log with its line numbers turned into `file:line`.
    [[nodiscard]] std::string map_log(std::string_view log) const;
};

/// Expands a file of glsl/ (`pass/ray_march.frag`): the version line, the defines, then the file
/// with each `#include "..."` put in once, however often it is named.
/// @throws Error if a file is not there.
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
