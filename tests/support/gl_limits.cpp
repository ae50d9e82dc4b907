#include "support/gl_limits.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fmt/format.h>
#include <glad/gl.h>
#include <string_view>

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

    void check(const Stage& stage, int outputs)
    {
        int samplers = 0, grid_samplers = 0, images = 0;
        for (GLuint i = 0; i < GLuint(count_of(program_, GL_UNIFORM)); ++i) {
            const int type = ask(program_, GL_UNIFORM, i, GL_TYPE);
            const int size = std::max(ask(program_, GL_UNIFORM, i, GL_ARRAY_SIZE), 1);
            if (ask(program_, GL_UNIFORM, i, GL_BLOCK_INDEX) != -1 ||
                ask(program_, GL_UNIFORM, i, stage.referenced) == 0 ||
                (!is_image(type) && !is_sampler(type)))  // of a host: a matrix is 16 numbers
                continue;
            std::array<char, 64> name{};
            g_gl.GetProgramResourceName(program_, GL_UNIFORM, i, GLsizei(name.size()), nullptr,
                                        name.data());
            const std::string_view text(name.data());
            const bool of_grid = text.starts_with("u_grid_") || text.starts_with("u_page_");
            if (is_image(type))
                images += size;
            else if (is_sampler(type))
                (of_grid ? grid_samplers : samplers) += size;
            GLint unit = 0;
            g_gl.GetUniformiv(program_, ask(program_, GL_UNIFORM, i, GL_LOCATION), &unit);
            if (is_image(type))
                at_most("image unit", unit, kImageUnits - 1);
            else if (is_sampler(type))
                at_most("texture unit", unit, kCombinedTextureUnits - 1);
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
