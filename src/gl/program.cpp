#include "gl/program.h"

#include <fmt/format.h>
#include <regex>
#include <set>

#include "gl/label.h"
#include <fumarole/errors.h>

namespace fumarole::gl {

namespace {

constexpr std::string_view kInclude = "#include \"";

using Seen = std::set<std::string, std::less<>>;

void append_file(ExpandedSource& out, std::string_view file, Seen& seen);

void append_text(ExpandedSource& out, std::string_view file, std::string_view rest, Seen& seen)
{
    for (int line = 1; !rest.empty(); ++line) {
        const std::size_t end = std::min(rest.find('\n'), rest.size() - 1);
        const std::string_view text = rest.substr(0, end + 1);
        rest.remove_prefix(end + 1);
        if (text.starts_with(kInclude)) {
            const std::string_view name = text.substr(kInclude.size());
            append_file(out, name.substr(0, name.find('"')), seen);
        } else if (!text.starts_with("#pragma once")) {
            out.text += text;
            out.origin.emplace_back(file, line);
        }
    }
}

void append_file(ExpandedSource& out, std::string_view file, Seen& seen)
{
    if (!seen.emplace(file).second)
        return;
    const auto found = shader_files().find(file);
    if (found == shader_files().end())
        throw Error(fmt::format("glsl/{}: no such shader file", file));
    append_text(out, file, found->second, seen);
}

/// The lines ahead of every source.
ExpandedSource expand_head(const Defines& defines)
{
    ExpandedSource out;
    out.text = "#version 450 core\n";
    out.origin.emplace_back("(version)", 1);
    for (const auto& [name, value] : defines) {
        out.text += fmt::format("#define {} {}\n", name, value);
        out.origin.emplace_back("(defines)", static_cast<int>(out.origin.size()));
    }
    return out;
}

class Shader {
public:
    Shader(const Device& gl, GLenum stage, std::string_view file, const ExpandedSource& source)
        : handle_{gl, gl->CreateShader(stage)}
    {
        const char* text = source.text.c_str();
        gl->ShaderSource(id(), 1, &text, nullptr);
        gl->CompileShader(id());
        GLint good = GL_FALSE;
        gl->GetShaderiv(id(), GL_COMPILE_STATUS, &good);
        if (good == GL_TRUE)
            return;
        GLint length = 0;
        gl->GetShaderiv(id(), GL_INFO_LOG_LENGTH, &length);
        std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
        gl->GetShaderInfoLog(id(), length, nullptr, log.data());
        throw Error(fmt::format("glsl/{}: does not compile on {}:\n{}", file,
                                gl.capabilities().renderer, source.map_log(log)));
    }
    [[nodiscard]] GLuint id() const { return handle_.id(); }

private:
    static void destroy(const Device& gl, GLuint id) { gl->DeleteShader(id); }
    Handle<&Shader::destroy> handle_;
};

GLenum stage_of(std::string_view file)
{
    return file.ends_with(".vert")   ? GL_VERTEX_SHADER
           : file.ends_with(".frag") ? GL_FRAGMENT_SHADER
                                     : GL_COMPUTE_SHADER;
}

}  // namespace

std::string ExpandedSource::map_log(std::string_view log) const
{
    // Mesa writes 0:LINE(COLUMN), NVIDIA 0(LINE).
    static const std::regex place(R"(\b0[:(](\d+)\)?)");
    std::string mapped;
    const std::string whole(log);
    auto at = whole.cbegin();
    for (std::sregex_iterator match(whole.begin(), whole.end(), place), end; match != end;
         ++match) {
        mapped.append(at, (*match)[0].first);
        const auto line = static_cast<std::size_t>(std::stoul((*match)[1].str()));
        mapped += line >= 1 && line <= origin.size()
                      ? fmt::format("glsl/{}:{}", origin[line - 1].first, origin[line - 1].second)
                      : (*match)[0].str();
        at = (*match)[0].second;
    }
    mapped.append(at, whole.cend());
    return mapped;
}

ExpandedSource expand_shader(std::string_view file, const Defines& defines)
{
    ExpandedSource out = expand_head(defines);
    Seen seen;
    append_file(out, file, seen);
    return out;
}

ExpandedSource expand_text(std::string_view name, std::string_view text, const Defines& defines)
{
    ExpandedSource out = expand_head(defines);
    Seen seen;
    append_text(out, name, text, seen);
    return out;
}

Program::Program(const Device& gl, const std::vector<std::string>& files, const Defines& defines)
    : handle_{gl, gl->CreateProgram()}
{
    std::vector<Shader> shaders;
    std::vector<GLuint> ids;
    for (const std::string& file : files) {
        shaders.emplace_back(gl, stage_of(file), file, expand_shader(file, defines));
        ids.push_back(shaders.back().id());
    }
    link(files.back(), ids);
}

Program Program::compute(const Device& gl, std::string_view name, const ExpandedSource& source)
{
    Program program;
    program.handle_ = {gl, gl->CreateProgram()};
    const Shader shader(gl, GL_COMPUTE_SHADER, name, source);
    program.link(name, {shader.id()});
    return program;
}

void Program::link(std::string_view name, const std::vector<GLuint>& shaders) const
{
    const Device& gl = handle_.device();
    set_label(gl, GL_PROGRAM, id(), name);
    for (const GLuint shader : shaders)
        gl->AttachShader(id(), shader);
    gl->LinkProgram(id());
    for (const GLuint shader : shaders)
        gl->DetachShader(id(), shader);
    GLint good = GL_FALSE;
    gl->GetProgramiv(id(), GL_LINK_STATUS, &good);
    if (good == GL_TRUE)
        return;
    GLint length = 0;
    gl->GetProgramiv(id(), GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
    gl->GetProgramInfoLog(id(), length, nullptr, log.data());
    throw Error(
        fmt::format("glsl/{}: does not link on {}: {}", name, gl.capabilities().renderer, log));
}

const Program& ProgramCache::get(const std::vector<std::string>& files, const Defines& defines)
{
    const auto key = std::pair{files, defines};
    const auto found = programs_.find(key);
    if (found != programs_.end())
        return found->second;
    return programs_.emplace(key, Program(device_, files, defines)).first->second;
}

}  // namespace fumarole::gl
