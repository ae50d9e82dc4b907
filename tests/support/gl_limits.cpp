#include "support/gl_limits.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fmt/format.h>
#include <glad/gl.h>
#include <string_view>
#include <utility>
#include <vector>

namespace fumarole::test {

namespace {

gl::GetProc g_functions;
std::vector<std::string>* g_excess;
GladGLContext g_gl;

/// A stage, and the least that the tables 23.57 to 23.68 of the specification of OpenGL 4.5 let a
/// driver have of each.
struct Stage {
    std::string_view name;
    GLenum referenced;
    int samplers, images, storages, blocks;
};
constexpr std::array kStages{Stage{"vertex", GL_REFERENCED_BY_VERTEX_SHADER, 16, 0, 0, 14},
                             Stage{"fragment", GL_REFERENCED_BY_FRAGMENT_SHADER, 16, 8, 8, 14},
                             Stage{"compute", GL_REFERENCED_BY_COMPUTE_SHADER, 16, 8, 8, 14}};
constexpr int kCombinedTextureUnits = 96, kImageUnits = 8, kStorageBindings = 8,
              kBlockBindings = 84, kBlockBytes = 16384, kGroup = 1024, kOutputs = 8,
              kOutputResources = 8;
/// Three grids of bricks, which every driver takes.
constexpr int kGridSamplers = 6;

int ask(GLuint program, GLenum interface, GLuint i, GLenum what)
{
    GLint value = 0;
    g_gl.GetProgramResourceiv(program, interface, i, 1, &what, 1, nullptr, &value);
    return value;
}

int count_of(GLuint program, GLenum interface)
{
    GLint count = 0;
    g_gl.GetProgramInterfaceiv(program, interface, GL_ACTIVE_RESOURCES, &count);
    return count;
}

bool is_image(int type)
{
    return type >= GL_IMAGE_1D && type <= GL_UNSIGNED_INT_IMAGE_2D_MULTISAMPLE_ARRAY;
}

/// All that is no block's member and no image, in shaders that have no other uniforms than those.
bool is_sampler(int type)
{
    constexpr std::array kNumbers{GL_FLOAT,        GL_FLOAT_VEC2, GL_FLOAT_VEC3,
                                  GL_FLOAT_VEC4,   GL_INT,        GL_INT_VEC2,
                                  GL_UNSIGNED_INT, GL_FLOAT_MAT4, GL_UNSIGNED_INT_VEC2};
    return !is_image(type) && std::find(kNumbers.begin(), kNumbers.end(), type) == kNumbers.end();
}

class Counts {
public:
    explicit Counts(GLuint program) : program_{program}
    {
        std::array<char, 128> label{};
        g_gl.GetObjectLabel(GL_PROGRAM, program, GLsizei(label.size()), nullptr, label.data());
        name_ = label.data();
    }

    void check()
    {
        find_opaque();
        const int outputs = is_fragment() ? count_of(program_, GL_PROGRAM_OUTPUT) : 0;
        at_most("fragment outputs", outputs, kOutputs);
        for (const Stage& stage : kStages)
            check(stage, stage.referenced == GL_REFERENCED_BY_FRAGMENT_SHADER ? outputs : 0);
        for (GLuint i = 0; i < GLuint(count_of(program_, GL_UNIFORM_BLOCK)); ++i) {
            at_most("bytes of a uniform block",
                    ask(program_, GL_UNIFORM_BLOCK, i, GL_BUFFER_DATA_SIZE), kBlockBytes);
            at_most("uniform binding", ask(program_, GL_UNIFORM_BLOCK, i, GL_BUFFER_BINDING),
                    kBlockBindings - 1);
        }
        for (GLuint i = 0; i < GLuint(count_of(program_, GL_SHADER_STORAGE_BLOCK)); ++i)
            at_most("storage binding", ask(program_, GL_SHADER_STORAGE_BLOCK, i, GL_BUFFER_BINDING),
                    kStorageBindings - 1);
        if (is_compute()) {
            std::array<GLint, 3> group{};
            g_gl.GetProgramiv(program_, GL_COMPUTE_WORK_GROUP_SIZE, group.data());
            at_most("invocations of a group", group[0] * group[1] * group[2], kGroup);
        }
    }

private:
    [[nodiscard]] bool is_compute() const { return has_stage(GL_COMPUTE_SHADER); }
    [[nodiscard]] bool is_fragment() const { return has_stage(GL_FRAGMENT_SHADER); }
    [[nodiscard]] bool has_stage(GLint stage) const
    {
        std::array<GLuint, 8> shaders{};
        GLsizei count = 0;
        g_gl.GetAttachedShaders(program_, GLsizei(shaders.size()), &count, shaders.data());
        return std::any_of(shaders.begin(), shaders.begin() + count, [&](GLuint shader) {
            GLint type = 0;
            g_gl.GetShaderiv(shader, GL_SHADER_TYPE, &type);
            return type == stage;
        });
    }

    /// All of a uniform is asked for at once, for all stages: Mesa looks through all of a program's
    /// uniforms for each question, and some have a thousand, which took half of all tests' time.
    void find_opaque()
    {
        constexpr std::array<GLenum, 7> kAsked{
            GL_TYPE,
            GL_ARRAY_SIZE,
            GL_BLOCK_INDEX,
            GL_LOCATION,
            kStages[0].referenced,
            kStages[1].referenced,
            kStages[2].referenced,
        };
        const auto count = GLuint(count_of(program_, GL_UNIFORM));
        for (GLuint i = 0; i < count; ++i) {
            std::array<GLint, kAsked.size()> found{};
            g_gl.GetProgramResourceiv(program_, GL_UNIFORM, i, GLsizei(kAsked.size()),
                                      kAsked.data(), GLsizei(found.size()), nullptr, found.data());
            const auto [type, size, block, location, by_vertex, by_fragment, by_compute] = found;
            if (block != -1 || (!is_image(type) && !is_sampler(type)))
                continue;  // of a host: a matrix is 16 numbers
            Opaque one{is_image(type), false, std::max(size, 1), 0, {}};
            std::array<char, 64> name{};
            g_gl.GetProgramResourceName(program_, GL_UNIFORM, i, GLsizei(name.size()), nullptr,
                                        name.data());
            const std::string_view text(name.data());
            one.of_grid = text.starts_with("u_grid_") || text.starts_with("u_page_");
            g_gl.GetUniformiv(program_, location, &one.unit);
            for (std::size_t k = 0; k < kStages.size(); ++k)
                if (found.at(4 + k) != 0)
                    one.referenced.push_back(kStages.at(k).referenced);
            opaque_.push_back(std::move(one));
        }
    }

    void check(const Stage& stage, int outputs)
    {
        int samplers = 0, grid_samplers = 0, images = 0;
        for (const Opaque& one : opaque_) {
            if (std::find(one.referenced.begin(), one.referenced.end(), stage.referenced) ==
                one.referenced.end())
                continue;
            (one.is_image ? images : one.of_grid ? grid_samplers : samplers) += one.size;
            at_most(one.is_image ? "image unit" : "texture unit", one.unit,
                    (one.is_image ? kImageUnits : kCombinedTextureUnits) - 1);
        }
        const auto referenced = [&](GLenum interface) {
            int count = 0;
            for (GLuint i = 0; i < GLuint(count_of(program_, interface)); ++i)
                count += ask(program_, interface, i, stage.referenced);
            return count;
        };
        const int storages = referenced(GL_SHADER_STORAGE_BLOCK);
        const auto of_stage = [&](const char* what) {
            return fmt::format("{} {}", stage.name, what);
        };
        at_most(of_stage("samplers, with those of three grids"),
                samplers + std::min(grid_samplers, kGridSamplers), stage.samplers);
        at_most(of_stage("images"), images, stage.images);
        at_most(of_stage("storage blocks"), storages, stage.storages);
        at_most(of_stage("uniform blocks"), referenced(GL_UNIFORM_BLOCK), stage.blocks);
        at_most(of_stage("images, storage blocks and outputs"), images + storages + outputs,
                kOutputResources);
    }

    void at_most(std::string_view what, int count, int limit)
    {
        if (count > limit)
            g_excess->push_back(fmt::format("glsl/{}: {}: {}, and OpenGL 4.5 promises {}", name_,
                                            what, count, limit));
    }

    /// An image or a sampler.
    struct Opaque {
        bool is_image = false, of_grid = false;
        int size = 0, unit = 0;
        std::vector<GLenum> referenced;  ///< Stage's
    };
    std::vector<Opaque> opaque_;
    GLuint program_;
    std::string name_;
};

void GLAD_API_PTR link_and_look(GLuint program)
{
    g_gl.LinkProgram(program);
    GLint linked = GL_FALSE;
    g_gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked == GL_TRUE)
        Counts(program).check();
}

void (*function_named(const char* name))()
{
    return std::strcmp(name, "glLinkProgram") == 0 ? reinterpret_cast<void (*)()>(link_and_look)
                                                   : g_functions(name);
}

}  // namespace

gl::GetProc with_limits(gl::GetProc functions, std::vector<std::string>& excess)
{
    g_functions = functions;
    g_excess = &excess;
    gladLoadGLContext(&g_gl, functions);
    return function_named;
}

}  // namespace fumarole::test
