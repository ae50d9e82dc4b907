#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fumarole/bounds.h>
#include <fumarole/export.h>
#include <fumarole/frame.h>
#include <fumarole/gl.h>
#include <fumarole/host_glsl.h>
#include <fumarole/inspection.h>
#include <fumarole/log.h>
#include <fumarole/probe_state.h>
#include <fumarole/program_store.h>
#include <fumarole/scene.h>
#include <fumarole/settings.h>
#include <fumarole/timing.h>
#include <fumarole/view.h>

namespace fumarole {

namespace gl {
class Device;  // gl/device.h
}
namespace medium {
struct MediaTraits;  // medium/media_set.h
}

/// A frame's two layers on the CPU, at its size.
struct LayerImages {
    std::vector<float> scattering;     ///< RGB, radiance W/m^2/sr, rows from the bottom
    std::vector<float> transmittance;  ///< RGB, 0..1
};

/// What transparents made of a frame on the CPU: `kept` times the picture that media and surfaces
/// make, plus `added`. RGB, rows from the bottom.
struct TransparentImages {
    std::vector<float> added;  ///< W/m^2/sr
    std::vector<float> kept;   ///< factor of what is behind; 0 where all of it is in `added`
};

/// What was worked out anew because the scene changed: what still holds is kept.
struct SceneWork {
    int grids_uploaded = 0;
    int meshes_uploaded = 0;
    int shadow_views = 0;   ///< shadow views drawn, of surfaces and of transparents that cast
    int extinctions = 0;    ///< volumes of the media's extinction that were filled
    int depth_layers = 0;   ///< volumes of optical depth towards a light that were filled
    int world_volumes = 0;  ///< volumes of the world's light that were filled
    int fields = 0;         ///< volumes of light that scatters again or is emitted that were filled
    int probes = 0;         ///< probes that were captured
    int lattices = 0;       ///< lattices of light that surfaces were drawn into
    int fires = 0;          ///< times that it was worked out what a large fire throws on surfaces

    bool operator==(const SceneWork&) const = default;
};

/// The fragments of transparents in one view: where a surface hides none, one for each transparent
/// and pixel. They are counted on the GPU, and known frames later.
struct FragmentCount {
    std::uint64_t fragments = 0;  ///< number in the last frame where it is known
    std::uint64_t lost = 0;  ///< number of the farthest ones without room: the next frame has it

    bool operator==(const FragmentCount&) const = default;
};

/// How often a frame evaluates the media, and how evenly its rays do.
struct SampleCounts {
    double all = 0;  ///< evaluations, shadows included
    /// Of a march: the mean of a ray over that of the longest in its square of 4 x 4 rays, and of
    /// 8 x 8, the squares that march counted by their longest. Rays that are worked out side by
    /// side take as long as the longest of them: the share of lanes that work. 0 in froxels, and
    /// where no ray marches.
    double even_4 = 0, even_8 = 0;
};

/// What a frame cost and did.
struct FrameReport {
    /// Milliseconds of each pass of one frame: the last whose times are known. Empty where no
    /// frame's have come to be known since the last report.
    std::vector<std::pair<std::string, double>> pass_ms;
    Timing timing = Timing::off;    ///< method by which they were measured
    std::uint64_t timed_frame = 0;  ///< Frame::index of the frame that they are of
    std::uint64_t gpu_bytes = 0;    ///< size of the renderer's textures and buffers [bytes]
    std::uint64_t allocations = 0;  ///< number of textures and buffers made so far
    std::string history;            ///< View::history() of the view that was drawn last
    /// What march and resolve of the last frame that saw a medium ran as (FrameSettings::passes).
    std::string passes;
    FragmentCount transparents;  ///< Renderer::fragment_count()
    std::uint64_t uploaded_bytes =
        0;                   ///< bytes of grids that were sent to the GPU since the last report
    bool uploading = false;  ///< set_scene()'s grids are on their way: its media are not seen yet
    SceneWork work;          ///< since the last report
};

/// The volumetric post-process. One for each GL context, which must be current in every call, the
/// destructor too. Holds no global state, makes no context, puts back the GL state that it changes.
class FUMAROLE_API Renderer {
public:
    /// @param log hears what is done otherwise than asked, and why
    /// @param programs keeps compiled programs between runs
    /// @throws Error if the context is older than OpenGL 4.5.
    explicit Renderer(gl::GetProc get_proc, Log log = {}, ProgramStore programs = {});
    ~Renderer();
    Renderer(Renderer&&) noexcept;
    Renderer& operator=(Renderer&&) noexcept;

    /// Media, lights, world, surfaces and transparents; here surfaces only hide light from the
    /// media (and are drawn by draw_surfaces). A grid or a mesh is uploaded once, known by its
    /// pointer, and what does not depend on what changed is kept (FrameReport::work tells): call
    /// this when the scene changes. LiveScene (live_scene.h) changes one part by part. The camera
    /// and the resolution of the scene are not used.
    /// @throws Error if the scene needs more than this GL has (texture units, sizes, memory),
    /// naming both; the renderer then holds no scene.
    /// Grids larger than set_upload_limit() has it are sent over some frames. Until all of a
    /// scene's are there, composite() draws it with the media of the scene before, whole; of
    /// scenes that come faster it leaves some out. The first scene is sent at once, and
    /// wait_until_ready() and prepare() send the rest.
    void set_scene(const Scene& scene, const SceneSettings& settings);

    /// Bytes of grids that a frame sends to the GPU at most, or one row of texels where that is
    /// more.
    void set_upload_limit(std::uint64_t bytes_a_frame);
    static constexpr std::uint64_t kUploadLimit = 32u << 20;  ///< without it

    /// Compiles what composite() and draw_surfaces() need for frames of the scene like this one, of
    /// any camera and size, so that the first of them compiles nothing. Compiling takes hundreds of
    /// milliseconds, so call it where those may pass, after set_scene(). It draws small pictures
    /// of its own: drivers finish shaders when they are first drawn with. `frame` is only looked
    /// at.
    void prepare(const Frame& frame, const FrameSettings& settings);

    /// A view of any size and mode, empty until its first frame.
    [[nodiscard]] View make_view(View::History history = View::History::kept);

    /// Composites the media over frame.color, color * transmittance + scattering, and the scene's
    /// transparents, each behind the media in front of it and over those behind.
    /// Without media and transparents it draws nothing and the picture keeps its bits.
    /// @throws Error if frame's sizes differ or its colour can't be drawn to.
    void composite(View& view, const Frame& frame, const FrameSettings& settings);

    /// Begins draws of the host's own transparents into a view's lists of fragments, ahead of
    /// composite() of the same frame and settings, which lays them over the picture with the
    /// scene's: by depth, and at one depth over the scene's. Whatever is drawn until
    /// end_transparents() by programs with transparent_glsl() of <fumarole/host_glsl.h> goes there;
    /// program, vertices, culling and clip control are the host's. Until then the draw framebuffer
    /// has no attachments and the picture's size, the viewport covers it, and what the lists need
    /// is bound to `bindings`.
    /// @throws Error if the frame's sizes differ, this GL has not so many bindings, or
    /// end_transparents() is missing
    void begin_transparents(View& view, const Frame& frame, const FrameSettings& settings,
                            const TransparentBindings& bindings);
    /// Ends them, and puts back framebuffer, viewport and what was bound before.
    /// @throws Error if none were begun
    void end_transparents(View& view);

    /// Draws the scene's own surfaces and its world into frame.color and frame.depth, for those who
    /// have no renderer of their own. through_media: light is dimmed by the media on its way.
    void draw_surfaces(const Frame& frame, const FrameSettings& settings, bool through_media);

    /// The layers that the last composite() of this frame blended, brought to its size in 32-bit
    /// floats. Empty where no medium is in view.
    LayerTextures layers(View& view, const Frame& frame, const FrameSettings& settings);

    /// layers(), read back: it waits for the GPU.
    LayerImages read_layers(View& view, const Frame& frame, const FrameSettings& settings);

    /// What the transparents of the last composite() of this frame did, read back: it waits for the
    /// GPU. Empty if the scene has none.
    TransparentImages read_transparents(View& view, const Frame& frame,
                                        const FrameSettings& settings);

    /// Draws what `inspection` asks for into frame.color, whose alpha stays; where there is nothing
    /// to show, the picture that is there shines through darkly. Call it in place of composite().
    /// frame.depth is read, and hides what lies behind surfaces. False colours, and transmittance,
    /// are linear colours for a screen at exposure 0; scattering is radiance.
    /// @throws Error as composite() does; if axis, position or scale is out of range; of a slice of
    /// froxels in another mode.
    InspectionLegend inspect(View& view, const Frame& frame, const FrameSettings& settings,
                             const Inspection& inspection);

    /// Returns `settings` with every automatic value resolved for `frame` (today: `resolution`).
    /// @throws Error if its projection is neither perspective nor orthographic
    [[nodiscard]] FrameSettings settled(const View& view, const Frame& frame,
                                        const FrameSettings& settings) const;

    /// Evaluations of the media that the march of `frame` takes, shadows included.
    double count_samples(View& view, const Frame& frame, const FrameSettings& settings)
    {
        return sample_counts(view, frame, settings).all;
    }
    /// Likewise, and how evenly its rays do.
    SampleCounts sample_counts(View& view, const Frame& frame, const FrameSettings& settings);

    /// Which variant the scene and the settings need, and why: a line each. What a frame decides is
    /// named as such unless the settings are settled().
    [[nodiscard]] std::vector<std::string> explain(const FrameSettings& settings) const;

    /// What the media of the scene have, and where they are (metres, world); for studies.
    [[nodiscard]] const medium::MediaTraits& media_traits() const;
    [[nodiscard]] Bounds media_bounds() const;

    /// Captures the scene's probes, all that are out of date at once or only those that never were,
    /// and shows them at once: for stills, and before a sequence. composite() captures one a frame
    /// by SceneSettings::probe_update and lets what is new fade in. Does nothing where the scene
    /// has none.
    void update_probes(bool anew = true);
    /// The scene's probes, or those that are placed by themselves.
    [[nodiscard]] std::vector<ProbeState> probes() const;
    /// Draws a mirror ball and a matt ball of `radius` metres side by side over frame.color where
    /// each probe is that was captured: what it has seen, and the light of its harmonics. What
    /// frame.depth has in front hides them.
    void draw_probes(const Frame& frame, const FrameSettings& settings, double radius);
    /// Why a probe was placed by itself or was not, with the figure that decided; empty where the
    /// scene names its own, has no surfaces, or SceneSettings::probes is off.
    [[nodiscard]] std::string probe_placement() const;
    /// What a third turn of capturing would add, of what probes have seen, 0..1: worked out by two
    /// small captures, once with what was captured first and once with what was captured then.
    /// Nothing before both turns are there. Waits for the GPU.
    [[nodiscard]] std::optional<double> probes_next_turn() const;

    /// Waits for the GPU: for stills and tests, not for a frame loop. What a frame would go without
    /// for a while is there then: where no surface hides a sun is known to the march from a shadow
    /// map that comes back from the GPU some frames after set_scene(), and until then it takes
    /// shorter steps. No other call waits, but for those that return pixels or counts.
    void wait_until_ready();

    /// Times the passes of each frame from now on: from one composite() or inspect() to the next.
    void set_timing(Timing timing);
    [[nodiscard]] Timing timing() const;
    /// The method whose times can be believed on this device: queries, or, on a software
    /// rasteriser, finish.
    [[nodiscard]] Timing measuring_timing() const;
    /// What is known of the last frames, and held now. Never waits.
    FrameReport take_report();
    /// Of the view that was drawn last; zeros where nothing is transparent. Never waits.
    [[nodiscard]] FragmentCount fragment_count() const;
    [[nodiscard]] const gl::Device& device() const;

private:
    struct Parts;
    class Picture;
    std::unique_ptr<Parts> parts_;
};

}  // namespace fumarole
