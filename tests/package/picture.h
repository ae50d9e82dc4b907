#pragma once

// A host's picture and depth. Whoever includes this has included a GL loader before.

#include <fumarole/live_scene.h>
#include <fumarole/renderer.h>

#include <cstdio>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

/// A black picture with nothing in front of the sky.
struct Picture {
    GLuint color = 0, depth = 0;
    glm::ivec2 size{160, 90};

    Picture()
    {
        glCreateTextures(GL_TEXTURE_2D, 1, &color);
        glTextureStorage2D(color, 1, GL_RGBA16F, size.x, size.y);
        glCreateTextures(GL_TEXTURE_2D, 1, &depth);
        glTextureStorage2D(depth, 1, GL_DEPTH_COMPONENT32F, size.x, size.y);
        const float black[4] = {0, 0, 0, 1}, far_away = 1;
        glClearTexImage(color, 0, GL_RGBA, GL_FLOAT, black);
        glClearTexImage(depth, 0, GL_DEPTH_COMPONENT, GL_FLOAT, &far_away);
    }

    /// 0 if there is light in the picture and no GL error, as a program's exit code.
    int verdict(const char* host) const
    {
        std::vector<float> pixels(static_cast<std::size_t>(3 * size.x * size.y));
        glGetTextureImage(color, 0, GL_RGB, GL_FLOAT,
                          static_cast<GLsizei>(pixels.size() * sizeof(float)), pixels.data());
        double sum = 0;
        for (const float value : pixels)
            sum += static_cast<double>(value);
        const GLenum error = glGetError();
        std::printf("%s: mean of the picture %g, GL error %#x\n", host,
                    sum / static_cast<double>(pixels.size()), error);
        return sum > 0 && error == GL_NO_ERROR ? 0 : 1;
    }
};

/// A ball of smoke of 24 voxels a side, from numbers of the host's own.
inline fumarole::VoxelGrid ball()
{
    constexpr int kSide = 24;
    std::vector<float> density;
    for (int z = 0; z < kSide; ++z)
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                const glm::vec3 from = glm::vec3(x, y, z) - 11.5f;
                density.push_back(glm::dot(from, from) < 100.0f ? 1.0f : 0.0f);
            }
    const glm::dmat4 world_from_index =
        glm::scale(glm::translate(glm::dmat4(1.0), glm::dvec3(-1.5, -1.5, 1.5)), glm::dvec3(0.125));
    return fumarole::make_voxel_grid(density, glm::ivec3(kSide), world_from_index);
}

/// What the hosts that read no file draw: that ball under a sun.
inline int draw_ball(fumarole::gl::GetProc get_proc, const char* host)
{
    const Picture picture;
    fumarole::GridMedium smoke;
    smoke.density = std::make_shared<fumarole::VoxelGrid>(ball());
    smoke.sigma_s_per_density = {6, 6, 6};
    fumarole::LiveScene scene;
    const fumarole::MediumId ball_of_smoke = scene.add(smoke);
    scene.add(fumarole::SunLight{.direction_to_light = {-1, -1, 1}, .irradiance = {5, 5, 4}});
    fumarole::Renderer renderer(get_proc);
    fumarole::SceneSettings settings;
    settings.bounces = 0;  // what is scattered on depends on g
    renderer.set_scene(scene.scene(), settings);
    renderer.take_report();
    smoke.g = 0.5f;
    scene.update(ball_of_smoke, smoke);
    renderer.set_scene(scene.scene(), settings);
    if (renderer.take_report().work != fumarole::SceneWork{})
        return 1;  // another g fills nothing anew
    fumarole::Frame frame;
    frame.color = {picture.color, {picture.size, 1}};
    frame.depth = {picture.depth, {picture.size, 1}};
    frame.view_from_world = glm::lookAt(glm::dvec3(0, -12, 3), {0, 0, 3}, {0, 0, 1});
    frame.clip_from_view = glm::perspective(glm::radians(35.0), 16.0 / 9.0, 0.1, 100.0);
    fumarole::View view = renderer.make_view();
    renderer.composite(view, frame, fumarole::FrameSettings{});
    return picture.verdict(host);
}
