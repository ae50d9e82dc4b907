#pragma once

#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "gl/buffer.h"
#include "gl/program.h"

namespace fumarole::test {

/// Runs functions of glsl/lib over an array of inputs, in a compute shader. `source` includes what
/// it tests and defines `void kernel(int i)`, which reads in_data[i * IN + 0..] and writes
/// out_data[i * OUT + 0..], vec4s both. Textures and uniform blocks are the caller's to bind.
class Kernel {
public:
    Kernel(const gl::Device& device, std::string_view source, int in = 1, int out = 1,
           gl::Defines defines = {})
        : gl_{device}, in_{in}, out_{out}
    {
        defines.emplace_back("IN", std::to_string(in));
        defines.emplace_back("OUT", std::to_string(out));
        std::string text(kHead);
        text += source;
        text += kMain;
        program_ = gl::Program::compute(device, "kernel", gl::expand_text("kernel", text, defines));
    }

    /// inputs: `in` vec4s for each run; answers `out` vec4s for each.
    [[nodiscard]] std::vector<glm::vec4> operator()(const std::vector<glm::vec4>& inputs) const
    {
        const auto runs = static_cast<GLuint>(inputs.size()) / static_cast<GLuint>(in_);
        std::vector<glm::vec4> results(std::size_t{runs} * static_cast<std::size_t>(out_));
        const std::size_t bytes = results.size() * sizeof(glm::vec4);
        const gl::Buffer in(gl_, "kernel in", inputs.size() * sizeof(glm::vec4), inputs.data());
        const gl::Buffer out(gl_, "kernel out", bytes, results.data());
        gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, in.id());
        gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, out.id());
        gl_->UseProgram(program_.id());
        gl_->DispatchCompute((runs + kGroup - 1) / kGroup, 1, 1);
        gl_->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);  // for the read below
        gl_->GetNamedBufferSubData(out.id(), 0, static_cast<GLsizeiptr>(bytes), results.data());
        gl_->UseProgram(0);
        return results;
    }

    [[nodiscard]] GLuint program() const { return program_.id(); }

private:
    static constexpr GLuint kGroup = 64;
    static constexpr std::string_view kHead = R"(layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer InData { vec4 in_data[]; };
layout(std430, binding = 1) buffer OutData { vec4 out_data[]; };
)";
    static constexpr std::string_view kMain = R"(
void main()
{
    int i = int(gl_GlobalInvocationID.x);
    if (i < in_data.length() / IN)
        kernel(i);
}
)";

    const gl::Device& gl_;
    int in_, out_;
    gl::Program program_;
};

}  // namespace fumarole::test
