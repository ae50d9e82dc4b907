// Programs that are kept between runs: the next run compiles none of them, and whatever a store
// gives back is either taken by the driver or compiled anew, without a GL error.

#include <cstring>
#include <map>

#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/program_binary.h"
#include "support/gl_test.h"

namespace fumarole::test {
namespace {

/// A host's store in memory.
struct Memory {
    std::map<std::string, std::vector<std::byte>> programs;
    int loaded = 0, stored = 0;

    ProgramStore store()
    {
        return {.load =
                    [this](std::string_view key) {
                        const auto found = programs.find(std::string(key));
                        if (found == programs.end())
                            return std::vector<std::byte>();
                        ++loaded;
                        return found->second;
                    },
                .store =
                    [this](std::string_view key, const std::vector<std::byte>& program) {
                        ++stored;
                        programs[std::string(key)] = program;
                    }};
    }
};

class KeptPrograms : public GlTest {
protected:
    static bool driver_gives_programs_away()
    {
        return !gl().capabilities().program_formats.empty();
    }

    /// What a small program computes.
    static GLuint seven_times_six(const gl::Device& device)
    {
        const std::string text = "layout(local_size_x = 1) in;\n"
                                 "layout(std430, binding = 0) buffer B { uint answer; };\n"
                                 "void main() { answer = 7u * 6u + gl_WorkGroupID.x; }\n";
        const gl::Program program =
            gl::Program::compute(device, "answer.comp", gl::expand_text("answer.comp", text, {}));
        GLuint buffer = 0, answer = 0;
        device->CreateBuffers(1, &buffer);
        device->NamedBufferStorage(buffer, sizeof answer, &answer, 0);
        device->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer);
        device->UseProgram(program.id());
        device->DispatchCompute(1, 1, 1);
        device->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        device->GetNamedBufferSubData(buffer, 0, sizeof answer, &answer);
        device->UseProgram(0);
        device->DeleteBuffers(1, &buffer);
        return answer;
    }
};

TEST_F(KeptPrograms, AreNotCompiledAgainAndDrawTheSame)
{
    if (!driver_gives_programs_away())
        GTEST_SKIP() << "this driver gives no program away";
    Scene scene = empty_scene(16);
    BoxMedium fog;
    fog.min = {-1, -6, -1};
    fog.max = {1, -4, 1};
    fog.sigma_s = glm::vec3(0.4f);
    scene.media = {fog};
    scene.lights = {SunLight{{0.3, 0.2, 1}, glm::vec3(3)}};
    const Settings settings;
    Memory memory;
    const auto draw = [&] {
        SceneRenderer renderer(get_proc(), {}, memory.store());
        return renderer.render(scene, settings, {});
    };
    const Still first = draw();
    const int compiled = memory.stored;
    EXPECT_GT(compiled, 5);
    EXPECT_EQ(memory.loaded, 0);
    const Still second = draw();
    EXPECT_EQ(memory.stored, compiled) << "the second run compiles nothing";
    EXPECT_EQ(memory.loaded, compiled);
    EXPECT_EQ(first.composite, second.composite);
}

TEST_F(KeptPrograms, ThatAreDamagedOrForeignAreCompiledAnew)
{
    if (!driver_gives_programs_away())
        GTEST_SKIP() << "this driver gives no program away";
    Memory memory;
    const gl::Device device(get_proc(), {}, memory.store());
    ASSERT_EQ(seven_times_six(device), 42u);
    ASSERT_EQ(memory.programs.size(), 1u);
    auto& [key, kept] = *memory.programs.begin();
    const std::vector<std::byte> whole = kept;
    const auto binary = gl::unpack_program(whole, key);
    ASSERT_TRUE(binary.has_value());

    std::vector<std::byte> flipped = whole, cut(whole.begin(), whole.begin() + 80);
    flipped[whole.size() / 2] ^= std::byte{1};
    // Whole by our own account, but nothing that the driver knows: of a format that there is not,
    // and of one that there is.
    const auto other_format = gl::pack_program({0x1234, binary->bytes}, key);
    const auto nonsense =
        gl::pack_program({binary->format, std::vector<std::byte>(500, std::byte{0x5a})}, key);
    auto shortened = *binary;
    shortened.bytes.resize(shortened.bytes.size() / 2);
    for (const std::vector<std::byte>& bytes :
         {flipped, cut, {}, other_format, nonsense, gl::pack_program(shortened, key)}) {
        kept = bytes;
        memory.stored = 0;
        EXPECT_EQ(seven_times_six(device), 42u) << bytes.size();
        EXPECT_EQ(device->GetError(), GLenum(GL_NO_ERROR)) << bytes.size();
        EXPECT_EQ(memory.stored, 1) << "what is of no use is written over";
        EXPECT_EQ(gl::unpack_program(kept, key).has_value(), true);
    }
    kept = whole;
    memory.stored = 0;
    EXPECT_EQ(seven_times_six(device), 42u);
    EXPECT_EQ(memory.stored, 0);
}

gl::GetProc g_real_functions;
PFNGLGETINTEGERVPROC g_real_integers;

/// A driver that has no format for programs, which GL 4.5 allows.
void GLAD_API_PTR integers_without_formats(GLenum name, GLint* values)
{
    if (name == GL_NUM_PROGRAM_BINARY_FORMATS)
        *values = 0;
    else
        g_real_integers(name, values);
}

void (*functions_without_formats(const char* name))()
{
    if (std::strcmp(name, "glGetIntegerv") == 0)
        return reinterpret_cast<void (*)()>(integers_without_formats);
    if (std::strcmp(name, "glGetProgramBinary") == 0 || std::strcmp(name, "glProgramBinary") == 0)
        return nullptr;  // who calls it ends here
    return g_real_functions(name);
}

TEST_F(KeptPrograms, OfADriverThatGivesNoneAwayAreNotAskedFor)
{
    g_real_functions = get_proc();
    g_real_integers = reinterpret_cast<PFNGLGETINTEGERVPROC>(g_real_functions("glGetIntegerv"));
    Memory memory;
    const gl::Device device(functions_without_formats, {}, memory.store());
    EXPECT_FALSE(device.keeps_programs());
    EXPECT_EQ(seven_times_six(device), 42u);
    EXPECT_EQ(memory.stored + memory.loaded, 0);
}

}  // namespace
}  // namespace fumarole::test
