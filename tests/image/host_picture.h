#pragma once

#include "gl/texture.h"
#include "image_test.h"

namespace fumarole::test {

/// A host's picture in GL: colour and depth, and the frame that lends them.
class HostPicture {
public:
    HostPicture(const gl::Device& gl, glm::ivec2 size, GLenum depth_format = GL_DEPTH_COMPONENT32F,
                GLenum color_format = GL_RGBA32F)
        : color_{gl::Texture::make_2d(gl, "host colour", size, color_format, gl::Filter::nearest)},
          depth_{gl::Texture::make_2d(gl, "host depth", size, depth_format, gl::Filter::nearest)}
    {
        frame.color = color_.view();
        frame.depth = depth_.view();
    }

    /// Reversed depth in 0..1 with an infinite far plane, the plainest of all: depth is near / z.
    void look(const Camera& camera)
    {
        frame.depth_convention = {.zero_to_one = true, .reversed = true};
        frame.view_from_world = view_from_world(camera);
        frame.clip_from_view = clip_from_view(camera, glm::uvec2(size()), glm::dvec2(0));
        frame.clip_from_view[2][2] = 0;
        frame.clip_from_view[3][2] = camera.near;
    }
    /// One colour, and view_z [m] by pixel from the top left; 0 for the sky.
    void fill(glm::vec3 color, double near, const std::function<double(int x, int y)>& view_z)
    {
        std::vector<float> colors, depths;
        for (int y = size().y - 1; y >= 0; --y)
            for (int x = 0; x < size().x; ++x) {
                colors.insert(colors.end(), {color.r, color.g, color.b, 0.5f});
                const double z = view_z(x, y);
                depths.push_back(z == 0 ? 0.0f : static_cast<float>(near / z));
            }
        color_.upload(GL_RGBA, GL_FLOAT, colors.data());
        depth_.upload(GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
    }
    [[nodiscard]] Image read() const { return turned(color_.read(4), 4); }
    /// RGB of rows from the bottom, as Renderer::read_layers gives them.
    [[nodiscard]] Image turned(const std::vector<float>& from, int channels = 3) const
    {
        Image image{size().x, size().y, {"R", "G", "B"}, {}};
        for (int y = size().y - 1; y >= 0; --y)
            for (int x = 0; x < size().x; ++x)
                for (int c = 0; c < 3; ++c)
                    image.pixels.push_back(
                        from[static_cast<std::size_t>((y * size().x + x) * channels + c)]);
        return image;
    }
    [[nodiscard]] glm::ivec2 size() const { return glm::ivec2(color_.size()); }

    Frame frame;

private:
    gl::Texture color_, depth_;
};

/// Frames of a view, numbered from `first`.
/// @returns the last one's report
inline FrameReport draw_frames(Renderer& renderer, View& view, HostPicture& picture,
                               const Scene& scene, const Settings& settings, int frames,
                               std::uint64_t first = 0)
{
    picture.look(scene.camera);
    for (int i = 0; i < frames; ++i) {
        picture.frame.index = first + static_cast<std::uint64_t>(i);
        renderer.draw_surfaces(picture.frame, settings, false);
        renderer.composite(view, picture.frame, settings);
    }
    return renderer.take_report();
}

}  // namespace fumarole::test
