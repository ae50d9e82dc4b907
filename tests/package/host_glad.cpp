// The example of docs/library.md: a host that has a context, a loader, a picture and a depth buffer
// of its own.
#include <glad/gl.h>

#include <fumarole/asset/vdb_file.h>
#include <fumarole/renderer.h>

#include "osmesa_context.h"
#include "picture.h"

int main(int, char** argv)
{
    if (!make_osmesa_context() || gladLoadGL(OSMesaGetProcAddress) == 0)
        return 1;
    const Picture picture;

    // [docs]
    fumarole::GridMedium smoke;
    smoke.density =
        std::make_shared<fumarole::VoxelGrid>(fumarole::asset::load_grid(argv[1], "density").grid);
    smoke.sigma_s_per_density = {6, 6, 6};  // 1/m per unit of density
    fumarole::Scene scene;
    scene.media = {smoke};
    scene.lights = {fumarole::SunLight{.direction_to_light = {-1, -1, 1}, .irradiance = {5, 5, 4}}};

    fumarole::Renderer renderer(OSMesaGetProcAddress);  // the host's function loader
    renderer.set_scene(scene, fumarole::SceneSettings{});
    fumarole::View view = renderer.make_view();  // its layers, and what is kept of them
    fumarole::Frame frame;
    frame.color = {picture.color, {picture.size, 1}};  // borrowed: a texture's name and its size
    frame.depth = {picture.depth, {picture.size, 1}};
    frame.view_from_world = glm::lookAt(glm::dvec3(0, -12, 3), {0, 0, 3}, {0, 0, 1});
    frame.clip_from_view = glm::perspective(glm::radians(35.0), 16.0 / 9.0, 0.1, 100.0);
    renderer.composite(view, frame,
                       fumarole::FrameSettings{});  // color * transmittance + scattering
    // [docs]

    return picture.verdict("own glad, with fumarole-asset");
}
