#include "support/gl_test.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <string_view>

#include "support/gl_limits.h"
#include "support/temp_folder.h"

namespace fumarole::test {

std::pair<std::string, int> validate_shaders(const std::filesystem::path& folder)
{
    std::string names;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (const auto type = entry.path().extension();
            type == ".frag" || type == ".vert" || type == ".comp")
            names += entry.path().filename().string() + "\n";
    std::ofstream(folder / "names") << names;
    const bool there = std::system("glslangValidator --version > /dev/null 2>&1") == 0;
    if (names.empty() || !there)
        return {"", 0};
    // Said of each file: its name, and then what is wrong with it.
    const std::string command = fmt::format(
        "cd '{}' && xargs -P $(nproc) -n 100 -a names glslangValidator 2>&1", folder.string());
    FILE* pipe = popen(command.c_str(), "r");
    std::string said;
    std::array<char, 4096> part{};
    while (std::fgets(part.data(), part.size(), pipe) != nullptr)
        if (const std::string_view line(part.data());
            !line.ends_with(".frag\n") && !line.ends_with(".vert\n") && !line.ends_with(".comp\n"))
            said += line;
    return {said, pclose(pipe)};
}

namespace {

struct Shared {
    std::unique_ptr<gl::HeadlessContext> context;
    std::unique_ptr<gl::Device> device;
    std::unique_ptr<SceneRenderer> renderer;
    std::vector<std::string> errors, excess;
    gl::GetProc get_proc = nullptr;
};

Shared& shared()
{
    static Shared one;
    return one;
}

void GLAD_API_PTR on_message(GLenum, GLenum type, GLuint, GLenum, GLsizei length,
                             const GLchar* text, const void*)
{
    if (type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR)
        shared().errors.emplace_back(text, static_cast<std::size_t>(length));
}

/// Frees GL objects while their context still lives, and has every shader that was compiled
/// validated: glslangValidator minds the specification where drivers are lenient.
class Environment : public testing::Environment {
    void SetUp() override
    {
        if (std::getenv("FUMAROLE_SHADERS") == nullptr)
            setenv("FUMAROLE_SHADERS", shaders_.path().c_str(), 1);
    }

    void TearDown() override
    {
        shared().renderer.reset();
        shared().device.reset();
        shared().context.reset();
        const auto [said, code] = validate_shaders(std::getenv("FUMAROLE_SHADERS"));
        EXPECT_EQ(code, 0) << said.substr(0, 4000);
    }

    TempFolder shaders_;
};

const auto* const g_environment = testing::AddGlobalTestEnvironment(new Environment);

}  // namespace

GlTest::GlTest()
{
    Shared& s = shared();
    if (s.context == nullptr) {
        const char* backend = std::getenv("FUM_TEST_BACKEND");
        const bool egl = backend != nullptr && std::string_view(backend) == "egl";
        s.context = gl::HeadlessContext::make(egl ? gl::Backend::egl : gl::Backend::osmesa);
        s.get_proc = with_limits(s.context->get_proc(), s.excess);
        s.device = std::make_unique<gl::Device>(s.get_proc);
        const gl::Device& device = *s.device;
        device->Enable(GL_DEBUG_OUTPUT);
        device->Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
        device->DebugMessageCallback(on_message, nullptr);
    }
    s.errors.clear();
    s.excess.clear();
}

GlTest::~GlTest()
{
    for (const std::string& error : shared().errors)
        ADD_FAILURE() << "OpenGL reports: " << error;
    for (const std::string& excess : shared().excess)
        ADD_FAILURE() << excess;
}

gl::GetProc GlTest::get_proc()
{
    return shared().get_proc;
}
const gl::Device& GlTest::gl()
{
    return *shared().device;
}

SceneRenderer& GlTest::scene_renderer()
{
    if (shared().renderer == nullptr)
        shared().renderer = std::make_unique<SceneRenderer>(get_proc());
    return *shared().renderer;
}

Still GlTest::render(const Scene& scene, const Settings& settings, int aa, StillReport* report)
{
    StillOptions options;
    options.aa = aa;
    return scene_renderer().render(scene, settings, options, report);
}

glm::vec3 pixel(const std::vector<float>& rgb, int width, int x, int y)
{
    const std::size_t i = (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(x)) *
                          3;
    return {rgb[i], rgb[i + 1], rgb[i + 2]};
}

Scene empty_scene(int size)
{
    Scene scene;
    scene.resolution = glm::uvec2(static_cast<unsigned>(size));
    scene.camera.position = {0, 0, 0};
    scene.camera.look_at = {0, -1, 0};
    scene.camera.vfov_deg = 20;
    scene.camera.near = 0.01;
    scene.camera.far = 1000;
    return scene;
}

}  // namespace fumarole::test
