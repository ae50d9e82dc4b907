#include "gl/program.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <optional>
#include <regex>
#include <set>

#include "gl/label.h"
#include "gl/program_binary.h"
#include <fumarole/errors.h>

namespace fumarole::gl {

namespace {

constexpr std::string_view kInclude = "#include \"";
constexpr std::string_view kWritten = "written/";

/// `const bool kName = false;` at a line's begin, in pieces; nothing if it is none.
struct Constant {
    std::string_view head, name, value, rest;
};

std::optional<Constant> constant_in(std::string_view line)
{
    if (!line.starts_with("const "))
        return std::nullopt;
    const std::size_t equals = line.find(" = "), end = line.find(';');
    const std::size_t name = line.find(' ', 6) + 1;
    if (equals == std::string_view::npos || end == std::string_view::npos || name > equals)
        return std::nullopt;
    return Constant{line.substr(0, equals + 3), line.substr(name, equals - name),
                    line.substr(equals + 3, end - equals - 3), line.substr(end)};
}

/// All that a file of glsl/ declares.
const std::set<std::string, std::less<>>& declared_constants()
{
    static const std::set<std::string, std::less<>> all = [] {
        std::set<std::string, std::less<>> names;
        for (const auto& [file, text] : shader_files())
            for (std::string_view rest = text; !rest.empty();) {
                const std::size_t end = std::min(rest.find('\n'), rest.size() - 1);
                if (const auto constant = constant_in(rest.substr(0, end)))
                    names.emplace(constant->name);
                rest.remove_prefix(end + 1);
            }
        return names;
    }();
    return all;
}

class Expansion {
public:
    explicit Expansion(const Defines& variant) : variant_{variant}
    {
        out_.text = "#version 450 core\n";
        out_.origin.emplace_back("(version)", 1);
        for (const auto& [name, value] : variant.entries()) {
            if (!Defines::is_constant(name))
                add_line(fmt::format("#define {} {}\n", name, value), "(defines)",
                         static_cast<int>(out_.origin.size()));
            else if (!declared_constants().contains(name))
                throw Error(fmt::format("no file of glsl/ declares a constant {}", name));
        }
    }

    void add_file(std::string_view file)
    {
        if (!seen_.emplace(file).second)
            return;
        if (const std::string* written = variant_.file(std::string(file))) {
            add_text(file, *written);
            return;
        }
        const auto found = shader_files().find(file);
        if (found != shader_files().end()) {
            add_text(file, found->second);
            return;
        }
        if (!file.starts_with(kWritten))
            throw Error(fmt::format("glsl/{}: no such shader file", file));
        add_line(fmt::format("#error {} is written for a scene, and this variant has none\n", file),
                 file, 1);
    }

    void add_text(std::string_view file, std::string_view rest)
    {
        for (int line = 1; !rest.empty(); ++line) {
            const std::size_t end = std::min(rest.find('\n'), rest.size() - 1);
            const std::string_view text = rest.substr(0, end + 1);
            rest.remove_prefix(end + 1);
            if (text.starts_with(kInclude)) {
                const std::string_view name = text.substr(kInclude.size());
                add_file(name.substr(0, name.find('"')));
            } else if (!text.starts_with("#pragma once")) {
                add_line(with_value(text), file, line);
            }
        }
    }

    ExpandedSource take() { return std::move(out_); }

private:
    void add_line(std::string_view text, std::string_view file, int line)
    {
        out_.text += text;
        out_.origin.emplace_back(file, line);
    }

    /// The line, its constant with the value that the variant gives it.
    [[nodiscard]] std::string with_value(std::string_view line) const
    {
        const auto constant = constant_in(line);
        const std::string* value = constant ? variant_.value_of(constant->name) : nullptr;
        if (value == nullptr)
            return std::string(line);
        if (value->starts_with("u_"))
            return fmt::format("#define {} ({}){}", constant->name, *value,
                               constant->rest.substr(1));
        return fmt::format("{}{}{}", constant->head, value->empty() ? "true" : *value,
                           constant->rest);
    }

    const Defines& variant_;
    ExpandedSource out_;
    std::set<std::string, std::less<>> seen_;
};

std::string_view line_of(std::string_view text, std::size_t line)
{
    for (; line > 1; --line)
        text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
    return text.substr(0, text.find('\n'));
}

/// Each shader that compiles goes into the folder that FUMAROLE_SHADERS names, as the GL got it.
void keep_text(std::string_view file, const std::string& text)
{
    const char* folder = std::getenv("FUMAROLE_SHADERS");
    if (folder == nullptr)
        return;
    const std::filesystem::path path(file);
    const std::string name = fmt::format("{}_{:016x}{}", path.stem().string(),
                                         std::hash<std::string>{}(text), path.extension().string());
    std::ofstream(std::filesystem::path(folder) / name) << text;
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
        if (good == GL_TRUE) {
            keep_text(file, source.text);
            return;
        }
        GLint length = 0;
        gl->GetShaderiv(id(), GL_INFO_LOG_LENGTH, &length);
        std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
        gl->GetShaderInfoLog(id(), length, &length, log.data());
        log.resize(static_cast<std::size_t>(std::max(length, 0)));
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

/// A program's key tells its stages by them.
const std::map<GLenum, std::string_view> kStageNames{
    {GL_VERTEX_SHADER, "vertex"}, {GL_FRAGMENT_SHADER, "fragment"}, {GL_COMPUTE_SHADER, "compute"}};

}  // namespace

void Defines::emplace_back(std::string name, std::string value)
{
    const auto same = [&](const Entry& entry) { return entry.first == name; };
    const auto found = std::find_if(entries_.begin(), entries_.end(), same);
    if (found != entries_.end())
        found->second = std::move(value);
    else
        entries_.emplace_back(std::move(name), std::move(value));
}

Defines& Defines::operator+=(const Defines& other)
{
    for (const Entry& entry : other.entries_)
        emplace_back(entry.first, entry.second);
    for (const auto& [name, text] : other.files_)
        add_file(name, text);
    return *this;
}

const std::string* Defines::value_of(std::string_view name) const
{
    for (const Entry& entry : entries_)
        if (entry.first == name)
            return &entry.second;
    return nullptr;
}

const std::string* Defines::file(const std::string& name) const
{
    const auto found = files_.find(name);
    return found != files_.end() ? &found->second : nullptr;
}

std::string ExpandedSource::map_log(std::string_view log) const
{
    // Mesa writes 0:LINE(COLUMN), NVIDIA 0(LINE).
    static const std::regex place(R"(\b0[:(](\d+)\)?)");
    std::string mapped;
    std::set<std::size_t> written;
    const std::string whole(log);
    auto at = whole.cbegin();
    for (std::sregex_iterator match(whole.begin(), whole.end(), place), end; match != end;
         ++match) {
        mapped.append(at, (*match)[0].first);
        const auto line = static_cast<std::size_t>(std::stoul((*match)[1].str()));
        if (line >= 1 && line <= origin.size() && origin[line - 1].first.starts_with(kWritten))
            written.insert(line);
        mapped += line >= 1 && line <= origin.size()
                      ? fmt::format("glsl/{}:{}", origin[line - 1].first, origin[line - 1].second)
                      : (*match)[0].str();
        at = (*match)[0].second;
    }
    mapped.append(at, whole.cend());
    for (const std::size_t line : written)
        mapped += fmt::format("\nglsl/{}:{}: {}", origin[line - 1].first, origin[line - 1].second,
                              line_of(text, line));
    return mapped;
}

ExpandedSource expand_shader(std::string_view file, const Defines& defines)
{
    Expansion expansion(defines);
    expansion.add_file(file);
    return expansion.take();
}

ExpandedSource expand_text(std::string_view name, std::string_view text, const Defines& defines)
{
    Expansion expansion(defines);
    expansion.add_text(name, text);
    return expansion.take();
}

Program::Program(const Device& gl, const std::vector<std::string>& files, const Defines& defines)
    : handle_{gl, gl->CreateProgram()}
{
    std::vector<ExpandedSource> sources;
    sources.reserve(files.size());
    for (const std::string& file : files)
        sources.push_back(expand_shader(file, defines));
    build(files, sources);
}

Program Program::compute(const Device& gl, std::string_view name, const ExpandedSource& source)
{
    Program program;
    program.handle_ = {gl, gl->CreateProgram()};
    program.build({std::string(name)}, {source});
    return program;
}

void Program::build(const std::vector<std::string>& files,
                    const std::vector<ExpandedSource>& sources)
{
    const Device& gl = handle_.device();
    set_label(gl, GL_PROGRAM, id(), files.back());
    std::string key;
    if (gl.keeps_programs()) {
        const Capabilities& driver = gl.capabilities();
        std::vector<std::string_view> texts{driver.vendor, driver.renderer, driver.version,
                                            driver.shading_language};
        for (std::size_t i = 0; i < files.size(); ++i)
            texts.insert(texts.end(), {kStageNames.at(stage_of(files[i])), sources[i].text});
        key = program_key(texts);
        if (load_program(gl, id(), key)) {
            for (std::size_t i = 0; i < files.size(); ++i)
                keep_text(files[i], sources[i].text);
            return;
        }
        gl->ProgramParameteri(id(), GL_PROGRAM_BINARY_RETRIEVABLE_HINT, GL_TRUE);
    }
    std::vector<Shader> shaders;
    std::vector<GLuint> ids;
    for (std::size_t i = 0; i < files.size(); ++i) {
        shaders.emplace_back(gl, stage_of(files[i]), files[i], sources[i]);
        ids.push_back(shaders.back().id());
    }
    link(files.back(), ids);
    if (!key.empty())
        store_program(gl, id(), key);
}

void Program::link(std::string_view name, const std::vector<GLuint>& shaders) const
{
    const Device& gl = handle_.device();
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
