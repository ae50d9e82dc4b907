#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fumarole/export.h>
#include <fumarole/renderer.h>

namespace fumarole {

/// A still of a scene and what it cost. RGB floats, rows from the top, linear.
struct Still {
    int width = 0, height = 0;
    int frames = 0;  ///< number of frames that were averaged
    /// surface_lit * transmittance + scattering, times what transparents keep, plus what they add,
    /// frame by frame.
    std::vector<float> composite;
    std::vector<float> scattering;     ///< W/m^2/sr
    std::vector<float> transmittance;  ///< 0..1
    std::vector<float> surface;        ///< the picture with no medium
    std::vector<float>
        surface_lit;  ///< surfaces as lit through the media, before the media veil them
    std::vector<float> transparents;       ///< what they add [W/m^2/sr]; empty if there are none
    std::vector<float> transparents_kept;  ///< likewise, what they keep of what is behind them
    std::vector<float> depth;  ///< one channel: view_z [m] at pixel centres, kSkyDepth in the sky
    /// RGBA, if asked for: media and surfaces without the sky, premultiplied; alpha is what of the
    /// sky they hide (one number can't say a coloured transmittance: 1 - its mean).
    std::vector<float> foreground;

    static constexpr float kSkyDepth = 1e10f;
};

struct PassTime {
    std::string name;
    double min_ms = 0, median_ms = 0, max_ms = 0;
};

/// Least, middle and largest of what was measured; zeros of nothing.
FUMAROLE_API PassTime summarize(std::string name, std::vector<double> ms);

struct StillReport {
    std::vector<PassTime> passes;  ///< each pass over the timed frames
    PassTime volume;               ///< all that the volume adds to a frame
    const char* timing_method = "";
    double samples = 0;  ///< media evaluations of the march in one frame, shadows included
    double even_4 = 0, even_8 = 0;  ///< SampleCounts' of that frame
    std::string history;            ///< FrameReport::history of the last timed frame
    std::string passes_as;          ///< FrameReport::passes of it
    std::uint64_t gpu_bytes = 0;
    double setup_ms = 0;  ///< uploads, shadow map and volumes of light, once
};

/// A frame's insides (Renderer::inspect). RGB floats, rows from the top, linear.
struct InspectionStill {
    int width = 0, height = 0;
    std::vector<float> pixels;
    InspectionLegend legend;
};

/// A part of a picture: pixels, from the top left.
struct PictureRegion {
    int x = 0, y = 0, width = 0, height = 0;

    bool operator==(const PictureRegion&) const = default;
};

/// The composite's mean over the first half of the frames so far, and over the second. RGB floats,
/// rows from the top, linear.
struct Halves {
    int frames = 0;  ///< number of frames of both, a power of two
    int width = 0;   ///< pixels of a row
    std::vector<float> first, second;
};

struct StillOptions {
    int aa = 1;  ///< frames averaged over the pixel's square; 1 samples pixel centres
    /// Ends the averaging before all of `aa` frames, once it says so. Asked after 8, 16, 32, ...
    /// frames: either half of a power of two of them is spread evenly over what they vary.
    std::function<bool(const Halves&)> enough = {};
    /// False: of a Still's pictures the composite alone, and the foreground if asked for; others
    /// cost as much again as drawing.
    bool layers = true;
    /// Repeats of the first frame that are timed, after one that is not. Settings that keep a
    /// history, where no frames are averaged, gather over them, and the picture is the frame that
    /// follows.
    int timed_frames = 1;
    bool picture = true;     ///< false: frames are timed alone, and the Still is empty
    std::uint32_t seed = 0;  ///< another seed, other jitter
    bool foreground = false;
    std::optional<PictureRegion> region = std::nullopt;  ///< this part of the picture alone
    /// Pixels along a side of what is drawn at once: a larger picture is drawn in tiles, to the
    /// same pixels, and its frames are counted (`enough`) on a smaller copy. 0: 4096, or less where
    /// the GL draws less.
    int most_side = 0;
    /// The number of a frame of a moving picture, which may have a history: the frames rendered
    /// before it. Its own drawing is what is timed. Where frames are averaged, each is its own.
    std::optional<std::uint64_t> moving_frame = std::nullopt;
    /// Called before each frame and at the end, with frames done and frames in all, the timed ones
    /// too. What it throws ends the render.
    std::function<void(int, int)> progress;
};

/// What a search among settings looks at: a single frame, jitter of seed 0, pixel centres.
struct Glance {
    std::vector<float> composite;  ///< as in Still
    PassTime volume;               ///< all that the volume adds to a frame
    double setup_ms = 0;           ///< as in StillReport
};

/// Draws whole scenes, surfaces and all, for those who have no renderer of their own: the command
/// line, the tests, the studies. A host to Renderer as any other.
class FUMAROLE_API SceneRenderer {
public:
    explicit SceneRenderer(gl::GetProc get_proc, Log log = {}, ProgramStore programs = {})
        : renderer_{get_proc, std::move(log), std::move(programs)},
          stills_{renderer_.make_view(View::History::none)}, moving_{renderer_.make_view()}
    {
    }

    /// @throws Error as Renderer does; if the region is not within the picture; if a region, or a
    /// picture in tiles, is to have a history, or froxels' shadows from what is in view
    Still render(const Scene& scene, const Settings& settings, const StillOptions& options,
                 StillReport* report = nullptr);

    /// The same picture as of render() without options, nothing else read back: a frame that is not
    /// timed, then up to `frames` that are, no more than one of them after `seconds`.
    /// @throws as render
    Glance glance(const Scene& scene, const Settings& settings, int frames, double seconds);

    /// One frame's insides, over the scene's surfaces as lit through the media.
    /// @throws Error as render() and Renderer::inspect do
    InspectionStill inspect(const Scene& scene, const Settings& settings,
                            const Inspection& inspection, std::uint32_t seed = 0);

    /// Hands the scene on unless the renderer holds it already: render() does so by itself, those
    /// who draw frames of their own call it first. @returns milliseconds
    double set_scene(const Scene& scene, const SceneSettings& settings, bool moves = false);

    /// As Renderer::settled() for the scene's camera and size.
    Settings settled(const Scene& scene, const Settings& settings);
    /// As render() has it with these options: averaged_resolution() too.
    Settings settled(const Scene& scene, const Settings& settings, const StillOptions& options);

    [[nodiscard]] Renderer& renderer() { return renderer_; }
    [[nodiscard]] const Renderer& renderer() const { return renderer_; }

private:
    struct Drawing;
    /// One part of a picture, at once.
    Still draw_part(const Drawing& drawing, const StillOptions& options, StillReport* report);
    /// Of the frame just drawn: waits for it.
    FrameReport timed_report();
    /// Likewise, whether there was no room for all that its transparents cover.
    bool has_lost_fragments();

    Renderer renderer_;
    View stills_;  ///< frames that are each a picture on its own
    View moving_;  ///< frames of a moving picture, or that gather
    std::optional<std::pair<Scene, SceneSettings>> held_;
};

/// Projection of a scene's camera for a picture of this size: reversed depth in [0, 1], which keeps
/// its relative precision to the horizon. offset: shift of the sample in its pixel, -0.5..0.5.
FUMAROLE_API glm::dmat4 clip_from_view(const Camera& camera, glm::uvec2 size, glm::dvec2 offset);
FUMAROLE_API glm::dmat4 view_from_world(const Camera& camera);

/// FrameSettings::resolution of frames that are averaged, where it is automatic: one step finer,
/// full instead of half. Averaging takes the grain away, and what half a resolution blurs would be
/// what is left. settled: what one frame alone would have
FUMAROLE_API int averaged_resolution(int settled);

/// Frame i of those that are averaged into a still of the scene, each with samples of its own, as
/// SceneRenderer draws them into textures of one size; in the depth convention of clip_from_view.
FUMAROLE_API Frame still_frame(const Camera& camera, const FrameSettings& settings,
                               gl::TextureView color, gl::TextureView depth, int i,
                               std::uint32_t seed);

/// Point i of a low-discrepancy set over the square -0.5..0.5; point 0 is its centre.
FUMAROLE_API glm::dvec2 subpixel_offset(int i);

}  // namespace fumarole
