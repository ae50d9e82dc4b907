#pragma once

#include <optional>
#include <string>

#include "gl/framebuffer.h"
#include "gl/program.h"
#include <fumarole/inspection.h>
#include <fumarole/scene_renderer.h>
#include <fumarole/write/image_writer.h>

namespace fumarole::window {

/// What a side is to show.
struct SideRequest {
    const Scene* scene = nullptr;  ///< its resolution is not used
    Settings settings;
    glm::ivec2 pixels{0};
    bool average = false;  ///< true at rest: frames are averaged, each with samples of its own
    int most = 16;         ///< frames that are averaged
    std::optional<Inspection> inspection;
    double probe_balls = 0;  ///< radius of the balls that stand for probes [m]; 0: none
};

/// One way to render and the picture that it has: a frame alone while things move, the mean of
/// several at rest, which is then what `fumarole render --aa` makes.
class Side {
public:
    /// @param log hears what the library says as it draws
    explicit Side(gl::GetProc get_proc, Log log = {});

    /// Draws one frame more. @returns false if the picture was complete already
    /// @throws Error as Renderer does; the picture is then what it was
    bool draw(const SideRequest& request);

    /// Linear, RGBA32F, alpha 1; empty before the first frame.
    [[nodiscard]] const gl::Texture& picture() const { return mean_; }
    /// RGB, rows from the top.
    [[nodiscard]] Image read() const;
    [[nodiscard]] int frames() const { return frames_; }
    /// Of the last frame.
    [[nodiscard]] const FrameReport& report() const { return report_; }
    [[nodiscard]] double setup_ms() const
    {
        return setup_ms_;
    }  ///< time of the last set_scene [ms]
    [[nodiscard]] const InspectionLegend& legend() const { return legend_; }
    [[nodiscard]] double samples(const SideRequest& request);
    [[nodiscard]] SceneRenderer& renderer() { return renderer_; }

private:
    struct Drawn {
        Scene scene;
        Settings settings;
        glm::ivec2 pixels;
        std::optional<Inspection> inspection;
        double probe_balls = 0;
    };
    [[nodiscard]] bool continues(const SideRequest& request) const;
    void resize(glm::ivec2 pixels);
    void accumulate(int frame);
    /// What is drawn with once the renderer has the scene.
    [[nodiscard]] Settings settings_of(const SideRequest& request) const;
    [[nodiscard]] Frame aim(const SideRequest& request, const Settings& settings, int frame) const;

    SceneRenderer renderer_;
    View stills_, live_;  ///< frames that are averaged; that move
    gl::ProgramCache programs_;
    gl::VertexArray fullscreen_;
    gl::Texture color_, depth_, mean_;
    gl::Framebuffer framebuffer_;
    std::optional<Drawn> drawn_;
    int frames_ = 0;
    std::uint64_t live_frames_ = 0;
    FrameReport report_;
    InspectionLegend legend_;
    double setup_ms_ = 0;
};

}  // namespace fumarole::window
