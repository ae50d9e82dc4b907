#pragma once

#include <string>
#include <vector>

#include "window/change.h"
#include "window/display_pass.h"
#include "window/document.h"
#include "window/layout.h"
#include "window/pace.h"
#include "window/reference_view.h"
#include "window/sides.h"
#include "window/view_state.h"

namespace fumarole::window {

/// What the drawing of frames took, for the panel.
struct DrawStatistics {
    double frame_ms = 0;  ///< time of the last frame, of all sides [ms]
    double samples = 0;   ///< evaluations of the media by side A at rest; 0 while unknown
    std::vector<float>
        gpu_ms;  ///< times of side A's passes in the last frames [ms], the oldest first
};

/// Which exposure is yet to be chosen where that is automatic.
class ExposureDue {
public:
    void note(Change change);
    /// Whether to choose it now: of a new scene from whatever picture there is, and once more when
    /// that is sharp, as after an edit.
    [[nodiscard]] bool now(bool settled) const { return at_once_ || (once_sharp_ && settled); }
    void chosen(bool settled);

private:
    bool once_sharp_ = true, at_once_ = true;
};

/// The picture's part of the window: side A, side B if something is compared, and the reference,
/// drawn as finely as the pace allows.
class Viewport {
public:
    /// @param device of the window's context, in which the sides' renderers are made too
    /// @param log as Side takes it
    Viewport(const gl::Device& device, gl::GetProc get_proc, Log log);

    /// Says what of the picture is out of date.
    void invalidate(Change change) { include(change_, change); }

    /// Asks for the reference where the state shows one, and takes what is there of it.
    /// @param pixels size of the picture at full effort @param now [s] on any clock
    void follow_reference(const Document& document, const ViewState& state, glm::ivec2 pixels,
                          double now);

    /// Draws a frame more of each side, and chooses the exposure where that is automatic.
    /// @param seconds since the last frame
    /// @returns why it could not be drawn, or ""; said once, until something changes
    std::string draw(const Document& document, ViewState& state, glm::ivec2 pixels, double seconds);

    /// What to show, and how. `a` has no picture before the first was drawn.
    [[nodiscard]] DisplayRequest displayed(const ViewState& state, const Layout& layout) const;

    /// Whether the picture is as sharp as it gets, or can't be drawn.
    [[nodiscard]] bool settled(const Document& document, const ViewState& state) const;
    /// Whether something moves, or has changed since the last frame.
    [[nodiscard]] bool moving() const { return change_ != Change::none || pace_.moving(); }
    [[nodiscard]] bool failed() const { return !sides_.error().empty(); }

    /// The still that `fumarole render` makes of a scene with the state's settings.
    Still still(const Scene& scene, const ViewState& state);
    /// What the scene needs and why, a line each (Renderer::explain).
    std::vector<std::string> explain(const Settings& settings);
    [[nodiscard]] const char* timing_method();

    [[nodiscard]] const Sides& sides() const { return sides_; }
    /// Of side A.
    [[nodiscard]] const Renderer& renderer() { return sides_.a().renderer().renderer(); }
    [[nodiscard]] const Pace& pace() const { return pace_; }
    [[nodiscard]] const ReferenceView& reference() const { return reference_; }
    [[nodiscard]] const DrawStatistics& statistics() const { return statistics_; }
    /// Relative difference at the end of the colours.
    [[nodiscard]] double difference_scale() const { return difference_.scale; }

private:
    struct DifferenceRange {
        double scale = 1;
        double tenth_of_mean_square = 0;  ///< as in DisplayRequest
    };
    /// Pixels of the reference on the GPU, for the display.
    struct ReferenceTexture {
        gl::Texture texture;
        std::uint64_t version = 0;  ///< ReferenceWorker::Picture::version of its pixels
    };

    [[nodiscard]] SideRequest request(const Scene& scene, const ViewState& state,
                                      const Settings& settings, glm::ivec2 pixels) const;
    void draw_sides(const Document& document, ViewState& state, glm::ivec2 pixels);
    void record(bool drawn, bool settled, const SideRequest& request);
    void choose_exposure(bool settled, ViewState& state);
    void measure_difference(const ViewState& state);
    void measure_errors(const ViewState& state);
    void upload_reference();

    const gl::Device& device_;
    Change change_ = Change::view;
    Pace pace_;
    Sides sides_;
    ReferenceView reference_;
    ReferenceTexture reference_tx_;
    ExposureDue exposure_;
    DifferenceRange difference_;
    DrawStatistics statistics_;
};

}  // namespace fumarole::window
