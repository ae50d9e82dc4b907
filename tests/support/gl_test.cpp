#include "support/gl_test.h"

#include <cstdlib>
#include <string_view>

namespace fumarole::test {

namespace {

struct Shared {
    std::unique_ptr<gl::HeadlessContext> context;
    std::unique_ptr<gl::Device> device;
    std::unique_ptr<SceneRenderer> renderer;
    std::vector<std::string> errors;
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

/// Frees GL objects while their context still lives.
class Environment : public testing::Environment {
    void TearDown() override
    {
        shared().renderer.reset();
        shared().device.reset();
        shared().context.reset();
    }
};

const auto* const g_environment = testing::AddGlobalTestEnvironment(new Environment);

}  // namespace

GlTest::GlTest()
{
    Shared& s = shared();
    if (s.context == nullptr) {
        const char* backend = std::getenv("FUM_TEST_BACKEND");
        const bool egl = backend != nullptr && std::string_view(backend) == "egl";
        s.context = gl::HeadlessContext::make(egl ? gl::HeadlessContext::Backend::egl
                                                  : gl::HeadlessContext::Backend::osmesa);
        s.device = std::make_unique<gl::Device>(s.context->get_proc());
        const gl::Device& device = *s.device;
        device->Enable(GL_DEBUG_OUTPUT);
        device->Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
        device->DebugMessageCallback(on_message, nullptr);
    }
    s.errors.clear();
}

GlTest::~GlTest()
{
    for (const std::string& error : shared().errors)
        ADD_FAILURE() << "OpenGL reports: " << error;
}

gl::GetProc GlTest::get_proc()
{
    return shared().context->get_proc();
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
