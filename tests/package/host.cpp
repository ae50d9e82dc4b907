// The README's example: a host that has a context, a picture and a depth buffer of its own.
#include <fumarole/asset/vdb_file.h>
#include <fumarole/gl/headless_context.h>
#include <fumarole/renderer.h>

#include <cstdio>
#include <glm/gtc/matrix_transform.hpp>

int main(int, char** argv)
{
    // The host's part: any OpenGL 4.5 context, a picture and its depth.
    const auto context =
        fumarole::gl::HeadlessContext::make(fumarole::gl::HeadlessContext::Backend::osmesa);
    const fumarole::gl::Device gl(context->get_proc());
    using fumarole::gl::Filter, fumarole::gl::Texture;
    const glm::ivec2 size(160, 90);
    const auto color = Texture::make_2d(gl, "host colour", size, GL_RGBA16F, Filter::nearest);
    const auto depth =
        Texture::make_2d(gl, "host depth", size, GL_DEPTH_COMPONENT32F, Filter::nearest);
    const float far_away = 1.0f;
    gl->ClearTexImage(depth.id(), 0, GL_DEPTH_COMPONENT, GL_FLOAT, &far_away);

    // [README]
    fumarole::GridMedium smoke;
    smoke.density =
        std::make_shared<fumarole::VoxelGrid>(fumarole::asset::load_grid(argv[1], "density").grid);
    smoke.sigma_s_per_density = {6, 6, 6};  // 1/m per unit of density
    fumarole::Scene scene;
    scene.media = {smoke};
    scene.lights = {fumarole::SunLight{.direction_to_light = {-1, -1, 1}, .irradiance = {5, 5, 4}}};

    fumarole::Renderer renderer(context->get_proc());  // the host's function loader
    renderer.set_scene(scene, fumarole::Settings{});
    fumarole::Frame frame;
    frame.color = color.view();  // borrowed: a texture's name and its size
    frame.depth = depth.view();
    frame.view_from_world = glm::lookAt(glm::dvec3(0, -12, 3), {0, 0, 3}, {0, 0, 1});
    frame.clip_from_view = glm::perspective(glm::radians(35.0), 16.0 / 9.0, 0.1, 100.0);
    renderer.composite(frame, fumarole::Settings{});  // color * transmittance + scattering
    // [README]

    double sum = 0;
    for (const float value : color.read(4))
        sum += value;
    std::printf("mean of the picture: %g\n", sum / (4.0 * size.x * size.y));
    return sum > 0 ? 0 : 1;
}
