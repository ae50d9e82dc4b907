#include "context/device_look.h"

#include <array>
#include <fmt/format.h>

#include "gl/buffer.h"
#include "gl/device.h"
#include "gl/program.h"

namespace fumarole::gl {

namespace {

constexpr GLuint kNumbers = 64;

/// Numbers that a driver can't have right by chance. @returns what is wrong, or ""
std::string first_dispatch(const Device& gl)
{
    const Program program = Program::compute(gl, "first_dispatch.comp",
                                             expand_text("first_dispatch.comp",
                                                         "layout(local_size_x = 64) in;\n"
                                                         "layout(std430, binding = 0) buffer B\n"
                                                         "{\n"
                                                         "    uint numbers[];\n"
                                                         "};\n"
                                                         "void main()\n"
                                                         "{\n"
                                                         "    uint i = gl_GlobalInvocationID.x;\n"
                                                         "    numbers[i] = 3u * i * i + 7u;\n"
                                                         "}\n",
                                                         {}));
    std::array<GLuint, kNumbers> numbers{};
    GLuint buffer = 0;
    gl->CreateBuffers(1, &buffer);
    gl->NamedBufferStorage(buffer, sizeof numbers, numbers.data(), 0);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer);
    gl->UseProgram(program.id());
    gl->DispatchCompute(1, 1, 1);
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->GetNamedBufferSubData(buffer, 0, sizeof numbers, numbers.data());
    gl->UseProgram(0);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, 0);
    gl->DeleteBuffers(1, &buffer);
    if (const GLenum error = gl->GetError(); error != GL_NO_ERROR)
        return fmt::format("its first dispatch ends in GL error {:#06x}", error);
    for (GLuint i = 0; i < kNumbers; ++i)
        if (numbers[i] != 3 * i * i + 7)
            return "its first dispatch computes wrong numbers";
    return "";
}

}  // namespace

DeviceDescription look_at_context(GetProc get_proc)
{
    DeviceDescription description;
    try {
        const Device gl(get_proc);
        const GLubyte* vendor = gl->GetString(GL_VENDOR);
        description.name = gl.capabilities().renderer;
        description.vendor = vendor != nullptr ? reinterpret_cast<const char*>(vendor) : "unknown";
        description.version = gl.capabilities().version;
        description.software = gl.capabilities().software;
        description.refusal = first_dispatch(gl);
    } catch (const Error& error) {
        description.refusal = error.what();
    }
    return description;
}

}  // namespace fumarole::gl
