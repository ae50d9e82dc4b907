#include <fumarole/renderer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "coming_scene.h"
#include "explain.h"
#include "gl/binding_guard.h"
#include "gl/framebuffer.h"
#include "gl/state_guard.h"
#include "gl/stopwatch.h"
#include "gl/timer.h"
#include "gl/transfer.h"
#include "light/light_set.h"
#include "light/light_volumes.h"
#include "light/probes.h"
#include "medium/media_set.h"
#include "pass/blue_noise.h"
#include "pass/fine_tiles.h"
#include "pass/sun_shades.h"
#include "prepared_frame.h"
#include "probe_captures.h"
#include "resolve/composite.h"
#include "resolve/inspect.h"
#include "resolve/layers.h"
#include "shared/bindings.h"
#include "shared/inspect_params.h"
#include "surface/surface_painter.h"
#include "surface/surface_set.h"
#include "toolbox.h"
#include "transparent/split_depths.h"
#include "transparent/transparent_painter.h"
#include "transparent/transparent_set.h"
#include "view_state.h"
#include <fumarole/errors.h>

namespace fumarole {

namespace {

constexpr glm::ivec2 kPreparedSize(16);  ///< prepared size of the pictures that prepare() draws

void check(const Frame& frame, const FrameSettings& settings)
{
    const glm::ivec2 color(frame.color.size), depth(frame.depth.size);
    if (!frame.color || !frame.depth || color != depth)
        throw Error(fmt::format("the frame's colour ({} x {}) and depth ({} x {}) must be textures "
                                "of one size",
                                color.x, color.y, depth.x, depth.y));
    const glm::ivec2 target(frame.target.size);
    if (frame.target && (target != color || frame.target.id == frame.color.id))
        throw Error(fmt::format("the frame's target ({} x {}) must be a texture of the size of its "
                                "colour ({} x {}), and another",
                                target.x, target.y, color.x, color.y));
    for (const TransparentExtent& one : frame.transparents)
        if (!(one.view_z.x <= one.view_z.y) || !glm::all(glm::lessThanEqual(one.low, one.high)))
            throw Error(fmt::format("Frame::transparents: an extent goes from view_z {} to {} m, "
                                    "pixel {}, {} to {}, {}; give the lesser first",
                                    one.view_z.x, one.view_z.y, one.low.x, one.low.y, one.high.x,
                                    one.high.y));
    fumarole::check(settings);
}

bool has_half_color(Settings::Format format)
{
    return format != Settings::Format::rgba32f;
}

/// What the shaders of glsl/host/transparent.glsl know of a frame.
shared::HostTransparentParams host_params(const PreparedFrame& frame, std::size_t first_draw)
{
    const glm::dmat4& clip = frame.host.clip_from_view;
    shared::HostTransparentParams params{};
    params.view_z_from_depth = frame.params.view_z_from_depth;
    if (frame.eye.perspective) {  // clip w = clip[2][3] z + clip[3][3]
        params.view_z_per_w = static_cast<float>(-1 / clip[2][3]);
        params.view_z_at_w = static_cast<float>(clip[3][3] / clip[2][3]);
    }
    params.sky_depth = frame.params.sky_depth;
    params.radiance_limit = frame.params.radiance_limit;
    params.first_draw = static_cast<std::uint32_t>(first_draw);
    params.half_color = has_half_color(frame.settings.format) ? 1 : 0;
    return params;
}

}  // namespace

struct Renderer::Parts {
    Parts(gl::GetProc get_proc, Log log, ProgramStore store)
        : shared_device{std::make_shared<gl::Device>(get_proc, std::move(log), std::move(store))},
          device{*shared_device}, programs{device}, timers{device}, surfaces{device}, media{device},
          lights{device, programs}, volumes{device, programs, timers}, probes{device, programs},
          fullscreen{device, "fullscreen"}, picture{device, "picture"}, color{device, "colour"},
          frame_block{device, "frame"}, depth_sampler{device, "scene depth"},
          blue_noise{pass::make_blue_noise(device)}, surface_painter{device}, transparents{device},
          transparent_painter{device}
    {
    }

    [[nodiscard]] FrameScene frame_scene() const;
    /// Storage buffers that a frame of a view uses.
    [[nodiscard]] int storages(const View::State& view, const FrameSettings& settings) const
    {
        const bool lists_fragments = !transparents.empty() || view.lists != nullptr;
        return lists_fragments || tools.computes(settings) ? STORAGE_COUNT : 0;
    }
    /// Puts those of a frame in order if they need no lists, and binds them as panes if they are.
    void order_transparents(const View::State& view, PreparedFrame& prepared,
                            transparent::SeenTransparents& seen) const;
    /// Has a march keep what it meets before the transparents of a frame, the host's too.
    void ask_depths(const View::State& view, PreparedFrame& prepared,
                    const transparent::SeenTransparents& seen) const;
    /// Empties a view's lists for the host's fragments of a frame.
    void begin_lists(View::State& view, const PreparedFrame& prepared) const;
    /// Forgets what the host drew for a frame other than this. @throws Error if there is some
    static void check_host_fragments(View::State& view, const PreparedFrame& prepared);
    /// Whether what is behind is asked for by a factor; it may be by any of the host's.
    [[nodiscard]] bool reads_picture(const View::State& view) const
    {
        return transparents.reads_picture() || view.lists_have_hosts;
    }
    [[nodiscard]] std::string explain_transparents(const FrameSettings& settings) const;
    /// Draws them into the view's lists. @returns whether there are any
    bool list_transparents(View::State& view, const PreparedFrame& prepared,
                           const transparent::SeenTransparents& seen);
    /// And lays them over a frame's picture. @param layers what media do in it; null: none is in
    /// view
    void draw_transparents(View::State& view, const PreparedFrame& prepared,
                           const transparent::SeenTransparents& seen, resolve::Layers* layers);
    /// A picture whose texels a look-up reads as blending takes them, where transparents look it
    /// up: those of an sRGB one it would decode. @param framebuffer has it for its colour
    gl::TextureView picture_behind(View::State& view, const PreparedFrame& prepared,
                                   const gl::Framebuffer& framebuffer,
                                   gl::TextureView texture) const;
    /// Lays those in order over a picture. @param layers likewise
    void lay_in_order(View::State& view, const PreparedFrame& prepared,
                      const transparent::SeenTransparents& seen, resolve::Layers* layers,
                      const transparent::Resolved& resolved) const;
    /// Settles a frame and binds what all passes read of it, the media and the lights too where it
    /// sees a medium.
    PreparedFrame begin(const View::State& view, const Frame& frame, const FrameSettings& s);
    [[nodiscard]] ViewPast past_of(const View::State& view, const Frame& frame) const;
    /// @param unseen a flag for each of those that are left out
    void draw_surfaces(const Frame& frame, const FrameSettings& s, bool through_media,
                       const std::vector<bool>& unseen = {});
    /// Lays what a frame's layers hold over its picture.
    void lay_media_over(resolve::Layers& layers, const PreparedFrame& prepared);
    /// Lays the media alone over a picture of their own view.
    void draw_media(View::State& view, const Frame& frame, const FrameSettings& s);
    [[nodiscard]] std::unique_ptr<View::State> make_state(View::History history) const;
    /// @throws Error if it is not a view of this renderer
    View::State& state_of(const View& view);
    /// All so far.
    [[nodiscard]] SceneWork work() const
    {
        const light::LightVolumeFills fills = volumes.fills();
        return {media.uploads(),    surfaces.uploads(), lights.views_drawn(), fills.extinction,
                fills.depth_layers, fills.world,        fills.field,          probes.captures(),
                fills.lattices,     fills.fires};
    }

    std::shared_ptr<const gl::Device>
        shared_device;  ///< device that is shared with the views, which may outlive us
    const gl::Device& device;
    gl::ProgramCache programs;
    gl::PassTimers timers;
    surface::SurfaceSet surfaces;
    medium::MediaSet media;
    light::LightSet lights;
    light::LightVolumes volumes;
    light::Probes probes;
    gl::VertexArray fullscreen;
    gl::Framebuffer picture,
        color;  ///< framebuffers that a frame is drawn to, and that it is read from
    gl::UniformBuffer<shared::FrameParams> frame_block;
    gl::Sampler depth_sampler;
    gl::Texture blue_noise;
    pass::SunShades sun_shades;
    /// Of the pictures that prepare() draws: a resolve by a compute shader is compiled for it.
    [[nodiscard]] GLenum prepared_format(const Frame& frame, const FrameSettings& settings) const
    {
        if (!tools.computes(settings))
            return GL_RGBA16F;
        const auto image = gl::image_format(device, frame.target ? frame.target : frame.color);
        return image ? image->format : GL_SRGB8_ALPHA8;  // none of an image's either
    }
    /// For prepare(): frames of a view that has a history, as if the scene had changed before each.
    void draw_changes(View& view, const std::function<void(const Frame&)>& draw, const Frame& still,
                      const Frame& moved);
    /// Takes note of what differs from the scene that was there before, media and all.
    void note_change(const Scene& now, const SceneSettings& settings);

    /// What is drawn, and what of it dims.
    struct Drawn {
        Scene scene;
        SceneSettings settings;
        std::vector<medium::Extinction> extinction;
    };
    std::optional<Drawn> drawn;
    /// Draws a scene from now on, with what it needs sent at once. @throws Error as set_scene()
    void show(const Scene& scene, const SceneSettings& settings);
    /// What of the media's glow is of lights of its own, which the media are told.
    light::Flames find_flames(const Scene& scene, const SceneSettings& settings);
    void forget_scene();
    /// Does it, and forgets the scene where it throws: half a scene is none.
    template <typename Change> void or_nothing(const Change& change);
    void composite(View& view, const Frame& frame, const FrameSettings& settings);
    void lay_over(View& view, const Frame& frame, const FrameSettings& settings);
    /// Fills what a change has left to be filled over frames.
    void go_on_filling();

    ComingScene coming{media};
    ProbeCaptures captures{device, timers, probes,
                           [this] { return View(make_state(View::History::none)); },
                           [this](const Frame& face, const FrameSettings& s, View& view,
                                  const std::vector<bool>& unseen) {
                               draw_surfaces(face, s, true, unseen);
                               draw_media(state_of(view), face, s);
                           }};
    void show_what_came();
    void finish_sending();
    std::uint64_t reported_bytes = 0;  ///< as far as take_report() has told

    std::uint64_t scene_id = 0, media_id = 0, life_id = 0;  ///< FrameScene's
    bool prepares = false;                                  ///< while prepare() draws
    /// How a frame's transparents are laid over its picture.
    enum class Way {
        lists,
        in_order,  ///< each by itself, a march having kept what it met at depths of the frame's
        at_panes,  ///< likewise, at the depths of each
        as_panes,  ///< all at once
    };
    /// Whether frames of the scene may have to.
    [[nodiscard]] bool may_lay(Way way) const;
    std::optional<Way> prepares_way;  ///< likewise, as if what they are had none but this
    /// While prepare() draws, and not after it, even if it throws.
    class Preparing {
    public:
        explicit Preparing(Parts& parts) : parts_{parts} { parts_.prepares = true; }
        Preparing(const Preparing&) = delete;
        Preparing& operator=(const Preparing&) = delete;
        ~Preparing()
        {
            parts_.prepares = false;
            parts_.prepares_way.reset();
            parts_.probes.set_preparing(false);
        }

    private:
        Parts& parts_;
    };
    SceneWork reported;  ///< as far as take_report() has told
    SceneSettings scene_settings;
    surface::SurfacePainter surface_painter;
    gl::UniformBuffer<shared::InspectParams> probe_balls;
    bool surfaces_are_drawn = false;  ///< since set_scene(): a host's own need no probes
    transparent::TransparentSet transparents;
    transparent::TransparentPainter transparent_painter;
    std::weak_ptr<transparent::FragmentLists>
        last_lists;                          ///< lists of the view that was drawn last
    std::uint64_t last_volume_at_bytes = 0;  ///< likewise, Layers::volume_at_bytes()
    bool last_at_panes = false;              ///< likewise, whether its panes were in order
    const Toolbox tools{device,        programs,   timers,         media,      lights,
                        volumes,       probes,     scene_settings, fullscreen, frame_block,
                        depth_sampler, blue_noise, sun_shades};
    std::string last_history;  ///< View::history() of the view that was drawn last
    std::string last_passes;   ///< FrameReport::passes of the last frame
    LayerChoice last_layer;    ///< of the frame that was settled or drawn last
};

FrameScene Renderer::Parts::frame_scene() const
{
    const medium::MediaDetail detail = media.detail();
    const Bounds bounds = media.bounds();
    // Around a point a frame has a ray for each pixel, around an area it has not, and in smoke
    // there is something to be seen there.
    const bool shines = std::isfinite(detail.grids) && lights.has_area_in(bounds);
    return {bounds,
            detail.boxes,
            detail.grids,
            shines ? 0 : lights.edge_width(bounds),
            detail.has_outline,
            static_cast<double>(media.traits().most_g),
            scene_id,
            media_id,
            life_id};
}

ViewPast Renderer::Parts::past_of(const View::State& view, const Frame& frame) const
{
    const View::State::Layer& last = view.last_layer;
    const bool same = last.picture_size == glm::ivec2(frame.color.size) && last.life_id == life_id;
    return {view.keeps_history, same ? last.scale : 0};
}

PreparedFrame Renderer::Parts::begin(const View::State& view, const Frame& frame,
                                     const FrameSettings& s)
{
    PreparedFrame prepared = prepare_frame(frame, s, frame_scene(), past_of(view, frame));
    prepared.prepares = prepares;
    last_layer = prepared.layer_choice;
    tools.bind(prepared);
    if (!prepared.sees_media)
        return prepared;
    const Eye& eye = prepared.eye;
    media.bind(eye.position);
    lights.bind(eye.position);
    const auto time = timers.scope("light volumes");
    volumes.bind(eye.position, eye.forward, eye.perspective, media);
    return prepared;
}

bool Renderer::Parts::may_lay(Way way) const
{
    const std::size_t all = transparents.size(), flat = all - transparents.listed();
    switch (way) {
    case Way::lists:  // what is in order in one view may cross in another
        return all > 1 || transparents.listed() > 0;
    case Way::in_order:  // as one may be steep
        return flat > 0;
    case Way::at_panes:
        return flat > transparents.plain_panes() || transparents.may_cross();
    case Way::as_panes:
        return transparents.plain_panes() > 0;
    }
    return false;
}

void Renderer::Parts::order_transparents(const View::State& view, PreparedFrame& prepared,
                                         transparent::SeenTransparents& seen) const
{
    // A host's own, in lists or shaded by the host, may lie anywhere between them.
    if (seen.list.empty() || view.lists_have_hosts || view.host_fragments ||
        !prepared.host.transparents.empty() || prepares_way == Way::lists ||
        prepared.settings.transparency != FrameSettings::Transparency::split)
        return;
    const auto is_plain = [&](const transparent::SeenTransparent& one) {
        return transparents.plain(one).has_value();
    };
    const auto needs_list = [&](const transparent::SeenTransparent& one) {
        return transparents.needs_list(one);
    };
    if (prepares_way) {  // one of each variant
        std::array<bool, 12> had{};
        std::erase_if(seen.list, [&](const transparent::SeenTransparent& one) {
            const std::size_t variant =
                (transparents.image(one) ? 1 : 0) + (transparents.fades(one) ? 2 : 0) +
                4 * static_cast<std::size_t>(1 + transparents.of_behind(one));
            return needs_list(one) || (prepares_way == Way::as_panes && !is_plain(one)) ||
                   (prepares_way == Way::at_panes && !transparents.is_flat(one)) ||
                   std::exchange(had.at(variant), true);
        });
    }
    if (std::any_of(seen.list.begin(), seen.list.end(), needs_list))
        return;
    std::vector<transparent::Placed> ordered = transparent::place(transparents, seen, prepared);
    if (!prepares_way) {
        auto found = transparent::put_in_order(std::move(ordered), prepared);
        if (!found)
            return;
        ordered = std::move(*found);
    }
    const std::vector<transparent::Placed> at_panes = transparent::panes_of(ordered);
    seen.in_order = true;
    seen.list.clear();
    for (const transparent::Placed& one : ordered)
        seen.list.push_back(one.seen);
    if (prepares_way && prepares_way != Way::as_panes && transparents.may_cross())
        for (const transparent::Placed& one : ordered)  // pieces of each as well
            for (const std::size_t cuts : {1, MAX_CUTS})
                if (one.is_flat) {
                    seen.list.push_back(one.seen);
                    seen.list.back().cuts.assign(cuts, glm::vec4(1));
                }
    if (at_panes.empty() || (prepares_way ? prepares_way == Way::in_order
                                          : !transparent::suit_march(at_panes, prepared)))
        return;
    const shared::PaneParams panes = transparent::pane_params(transparents, at_panes, prepared);
    transparent_painter.bind_panes(device, panes);
    prepared.panes = panes.count;
    seen.are_plain = prepares_way ? prepares_way == Way::as_panes
                                  : !transparent::has_pieces(ordered) &&
                                        std::all_of(seen.list.begin(), seen.list.end(), is_plain);
    // The same as panes come into view and leave it.
    prepared.pane_places = 1;
    while (prepared.pane_places <
           static_cast<int>(std::min<std::size_t>(transparents.size(), MAX_PANES)))
        prepared.pane_places *= 2;
}

void Renderer::Parts::ask_depths(const View::State& view, PreparedFrame& prepared,
                                 const transparent::SeenTransparents& seen) const
{
    std::vector<TransparentExtent> of_host = prepared.host.transparents;
    if (of_host.empty() && view.host_fragments)
        of_host.emplace_back();
    if ((seen.list.empty() && of_host.empty()) ||
        prepared.settings.mode != Settings::Mode::raymarch)
        return;
    for (const transparent::SeenTransparent& one : seen.list)
        prepared.depths_asked.areas.push_back(one.area);
    if (prepared.panes > 0)
        return;
    glm::dvec2 range = seen.view_z;
    for (const TransparentExtent& one : of_host) {
        prepared.depths_asked.areas.push_back({one.low, one.high});
        range = {std::min(range.x, one.view_z.x), std::max(range.y, one.view_z.y)};
    }
    if (prepared.settings.transparency != Settings::Transparency::split)
        range.y = std::numeric_limits<double>::infinity();  // they ask for the surface's depth too
    prepared.depths_asked.view_z =
        transparent::split_depths(media.occupied(), prepared, range, prepared.settings.splits);
}

void Renderer::Parts::begin_lists(View::State& view, const PreparedFrame& prepared) const
{
    if (view.lists == nullptr)
        view.lists = std::make_shared<transparent::FragmentLists>(device);
    view.lists->begin(prepared.picture_size, has_half_color(prepared.settings.format));
    view.host_fragments = {prepared.picture_size, prepared.settings.format, nullptr};
}

void Renderer::Parts::check_host_fragments(View::State& view, const PreparedFrame& prepared)
{
    if (!view.host_fragments)
        return;
    if (view.host_fragments->bindings != nullptr)
        throw Error("the host's transparents of this view have not ended; call "
                    "end_transparents() before composite()");
    if (view.host_fragments->size == prepared.picture_size &&
        view.host_fragments->format == prepared.settings.format)
        return;
    const glm::ivec2 theirs = view.host_fragments->size, ours = prepared.picture_size;
    view.host_fragments.reset();
    throw Error(fmt::format("begin_transparents() was given a frame of {} x {}, and composite() "
                            "one of {} x {} or of another FrameSettings::format; give both the "
                            "same",
                            theirs.x, theirs.y, ours.x, ours.y));
}

bool Renderer::Parts::list_transparents(View::State& view, const PreparedFrame& prepared,
                                        const transparent::SeenTransparents& seen)
{
    last_lists.reset();
    view.lists_have_hosts = view.host_fragments.has_value();
    view.host_fragments.reset();
    if (seen.list.empty() && !view.lists_have_hosts) {
        if (transparents.empty())
            view.drop_transparents();
        return false;
    }
    if (view.lists == nullptr)
        view.lists = std::make_shared<transparent::FragmentLists>(device);
    last_lists = view.lists;
    if (!view.lists_have_hosts)
        view.lists->begin(prepared.picture_size, has_half_color(prepared.settings.format));
    if (!seen.list.empty())
        transparent_painter.fill(tools, transparents, seen.list, *view.lists, prepared);
    view.lists->end();
    return true;
}

void Renderer::Parts::draw_transparents(View::State& view, const PreparedFrame& prepared,
                                        const transparent::SeenTransparents& seen,
                                        resolve::Layers* layers)
{
    last_volume_at_bytes = layers != nullptr ? layers->volume_at_bytes() : 0;
    last_at_panes = prepared.panes > 0;
    transparent::Resolved resolved{picture, prepared.picture()};
    if (seen.in_order) {
        const auto format = gl::image_format(device, resolved.picture);
        resolved.is_fine = format && format->format == GL_RGBA32F;
        last_lists.reset();
        lay_in_order(view, prepared, seen, layers, resolved);
        return;
    }
    if (!list_transparents(view, prepared, seen))
        return;
    resolved.reads_picture = reads_picture(view);
    resolved.picture = picture_behind(view, prepared, picture, resolved.picture);
    transparent_painter.resolve(tools, *view.lists, view.media_mask, layers, resolved, prepared);
}

gl::TextureView Renderer::Parts::picture_behind(View::State& view, const PreparedFrame& prepared,
                                                const gl::Framebuffer& framebuffer,
                                                gl::TextureView texture) const
{
    const bool looks =
        reads_picture(view) || prepared.settings.transparency != FrameSettings::Transparency::split;
    if (!looks || !gl::decodes_srgb(device, texture))
        return texture;
    transparent::FineTarget& copy = view.transparent_sum;
    copy.resize(device, prepared.picture_size);
    copy.framebuffer.copy_color_of(framebuffer, glm::ivec2(0), prepared.picture_size);
    return copy.texture.view();
}

void Renderer::Parts::lay_in_order(View::State& view, const PreparedFrame& prepared,
                                   const transparent::SeenTransparents& seen,
                                   resolve::Layers* layers,
                                   const transparent::Resolved& resolved) const
{
    if (seen.are_plain)
        transparent_painter.lay_panes(tools, view.pane_layer, view.media_mask, layers, resolved,
                                      prepared);
    else
        transparent_painter.lay_in_order(tools, transparents, seen.list, view.transparent_sum,
                                         view.media_mask, layers, resolved, prepared);
}

std::string Renderer::Parts::explain_transparents(const FrameSettings& settings) const
{
    constexpr double kMegabyte = 1e6;
    const auto lists = last_lists.lock();
    std::string line = fmt::format("transparents: {} of the scene, ", transparents.size());
    if (lists != nullptr)
        line += fmt::format("in a list of fragments a pixel, {:.1f} MB in the last view",
                            static_cast<double>(lists->bytes()) / kMegabyte);
    else
        line += "of which the last view needed no lists";
    if (settings.mode == Settings::Mode::froxel)
        return line + "; what media do before each is looked up in the froxels";
    line += !last_at_panes
                ? fmt::format("; the march keeps what it has met at {} depths", settings.splits)
                : "; the march keeps what it has met at the depth of each";
    if (last_volume_at_bytes > 0)
        line += fmt::format(", {:.1f} MB", static_cast<double>(last_volume_at_bytes) / kMegabyte);
    return line;
}

View::State& Renderer::Parts::state_of(const View& view)
{
    View::State* state = view.state_.get();
    if (state == nullptr || state->owner != this)
        throw Error(state == nullptr ? "the view was moved from; make another by make_view()"
                                     : "the view belongs to another Renderer; make one by this "
                                       "one's make_view()");
    return *state;
}

/// Where a frame's composite goes, attached while it lives: with the colour in it.
class Renderer::Picture {
public:
    Picture(Parts& parts, const Frame& frame) : framebuffer_{parts.picture}
    {
        framebuffer_.attach_color({frame.target ? frame.target : frame.color});
        if (!frame.target)
            return;
        parts.color.attach_color({frame.color});
        framebuffer_.copy_color_of(parts.color, glm::ivec2(0), glm::ivec2(frame.color.size));
        parts.color.detach_color();
    }
    Picture(const Picture&) = delete;
    Picture& operator=(const Picture&) = delete;
    ~Picture() { framebuffer_.detach_color(); }

private:
    gl::Framebuffer& framebuffer_;
};

Renderer::Renderer(gl::GetProc get_proc, Log log, ProgramStore programs)
    : parts_{std::make_unique<Parts>(get_proc, std::move(log), std::move(programs))}
{
}

void Renderer::Parts::draw_changes(View& view, const std::function<void(const Frame&)>& draw,
                                   const Frame& still, const Frame& moved)
{
    const std::uint64_t real_scene = scene_id, real_media = media_id;
    for (const bool is_media : {false, true}) {
        view.reset_history();
        draw(moved);
        for (const Frame* one : {&moved, &still, &still}) {
            ++scene_id;
            media_id += is_media ? 1u : 0u;
            draw(*one);
        }
        draw(still);
        draw(moved);
    }
    scene_id = real_scene;
    media_id = real_media;
}

void Renderer::Parts::note_change(const Scene& now, const SceneSettings& settings)
{
    std::vector<medium::Extinction> extinction = media.extinction();
    const auto is_same = [](const medium::Extinction& a, const medium::Extinction& b) {
        return medium::is_moved(a, b, glm::dvec3(0), 0);
    };
    if (!drawn || !same_content(drawn->scene, now))
        ++scene_id;
    if (!drawn || !std::equal(extinction.begin(), extinction.end(), drawn->extinction.begin(),
                              drawn->extinction.end(), is_same))
        ++media_id;
    if (media.empty() || !drawn || drawn->settings != settings)
        ++life_id;
    drawn.emplace(Drawn{now, settings, std::move(extinction)});
}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

void Renderer::set_scene(const Scene& scene, const SceneSettings& settings)
{
    check(settings);
    Parts& parts = *parts_;
    const bool anew = !parts.drawn || parts.drawn->settings != settings;
    if (!anew && parts.coming.is(scene))
        return;
    if (anew || parts.media.empty())
        parts.coming.forget();
    if (anew || parts.media.empty() || parts.media.has_grids(scene, settings)) {
        parts.coming.drop();
        parts.show(scene, settings);
        return;
    }
    parts.or_nothing([&] { parts.coming.await(scene, settings); });
    parts.show_what_came();
    if (!parts.coming.waits())
        return;
    Scene now = scene;
    now.media = parts.drawn->scene.media;
    now.time = parts.drawn->scene.time;
    parts.show(now, settings);
}

void Renderer::set_upload_limit(std::uint64_t bytes)
{
    parts_->coming.set_limit(bytes);
}

void Renderer::Parts::show_what_came()
{
    or_nothing([&] {
        coming.show_what_came(
            [&](const Scene& scene) { show(scene, SceneSettings(drawn->settings)); });
    });
}

void Renderer::Parts::finish_sending()
{
    coming.finish([&](const Scene& scene) { show(scene, SceneSettings(drawn->settings)); });
}

template <typename Change> void Renderer::Parts::or_nothing(const Change& change)
{
    try {
        change();
    } catch (...) {
        forget_scene();
        throw;
    }
}

void Renderer::Parts::forget_scene()
{
    media.clear();
    coming.forget();
    surfaces.set({});
    transparents.set({});
    lights.clear();
    volumes.clear();
    probes.clear();
    drawn.reset();
}

light::Flames Renderer::Parts::find_flames(const Scene& scene, const SceneSettings& settings)
{
    light::Flames flames;
    const std::size_t room = MAX_LIGHTS - std::min<std::size_t>(scene.lights.size(), MAX_LIGHTS);
    if (media.traits().emission && room > 0) {
        const light::FlameScale scale = light::flame_scale(settings, media, surfaces);
        flames = light::lights_of_flames(media.small_glows(scale.longest()), scale, scene.surfaces,
                                         room);
    }
    media.split_off(flames.split_off);
    return flames;
}

void Renderer::Parts::show(const Scene& scene, const SceneSettings& settings)
{
    const bool anew = !drawn || drawn->settings != settings;
    if (!anew && same_content(drawn->scene, scene))
        return;
    const auto casts = [](const Scene& one) { return light::casters_of(one.transparents); };
    if (!anew && drawn->scene.transparents != scene.transparents &&
        casts(drawn->scene) == casts(scene)) {
        // Nothing else sees them.
        transparents.set(scene.transparents);
        drawn->scene.transparents = scene.transparents;
        if (same_content(drawn->scene, scene))
            return;
    }
    const gl::StateGuard guard(device, BLOCK_COUNT, IMAGE_COUNT, STORAGE_COUNT);
    scene_settings = settings;
    or_nothing([&] {
        if (anew || drawn->scene.media != scene.media || drawn->scene.time != scene.time)
            media.set(scene, settings);
        if (anew || drawn->scene.surfaces != scene.surfaces)
            surfaces.set(scene.surfaces);
        if (anew || drawn->scene.transparents != scene.transparents)
            transparents.set(scene.transparents);
        const bool detailed = media.traits().marched > 0;
        const bool through_gaps = settings.shadow_map == kAutomatic && !detailed &&
                                  !scene.lights.empty() &&
                                  volumes.is_sky_in_parts(scene, media.bounds());
        const light::Flames flames = find_flames(scene, settings);
        lights.set(scene, surfaces, media.bounds(), settings.shadow_map, detailed, through_gaps,
                   flames.lights);
        lights.set_filters(scene, transparents.casters(), settings.shadow_map,
                           media.texture_units());
        probes.set(scene, settings, lights, media);
        if (probes.count() == 0)
            captures.forget();
        surfaces_are_drawn = false;
        volumes.set(scene, settings, media, surfaces, lights);
        note_change(scene, settings);
    });
}

View Renderer::make_view(View::History history)
{
    return View(parts_->make_state(history));
}

std::unique_ptr<View::State> Renderer::Parts::make_state(View::History history) const
{
    auto state = std::make_unique<View::State>();
    state->device = shared_device;
    state->owner = this;
    state->keeps_history = history == View::History::kept;
    return state;
}

FrameSettings Renderer::settled(const View& view, const Frame& frame,
                                const FrameSettings& settings) const
{
    const ViewPast past = parts_->past_of(parts_->state_of(view), frame);
    const PreparedFrame prepared = prepare_frame(frame, settings, parts_->frame_scene(), past);
    parts_->last_layer = prepared.layer_choice;
    return prepared.settings;
}

void Renderer::composite(View& view, const Frame& frame, const FrameSettings& settings)
{
    check(frame, settings);
    parts_->show_what_came();
    parts_->composite(view, frame, settings);
    parts_->coming.end_frame();
}

void Renderer::Parts::composite(View& view, const Frame& frame, const FrameSettings& settings)
{
    Parts& parts = *this;
    const auto timed = parts.timers.frame(frame.index);
    if (parts.surfaces_are_drawn && !parts.prepares)
        parts.captures.update(frame, parts.scene_id, parts.scene_settings.probe_update);
    parts.lay_over(view, frame, settings);
    if (parts.volumes.has_more() && !parts.prepares)
        parts.go_on_filling();
}

void Renderer::Parts::go_on_filling()
{
    const gl::StateGuard guard(device, BLOCK_COUNT, IMAGE_COUNT, STORAGE_COUNT);
    const auto time = timers.scope("light volumes, anew");
    if (volumes.go_on(media, surfaces, lights))
        ++scene_id;
}

void Renderer::Parts::lay_over(View& view, const Frame& frame, const FrameSettings& settings)
{
    Parts& parts = *this;
    View::State& state = parts.state_of(view);
    state.volume_at.reset();
    const bool is_asked = !frame.transparents.empty();
    const bool empty = parts.media.empty() && parts.transparents.empty() && !state.host_fragments;
    if (empty)
        state.drop_transparents();
    if (empty && !frame.target && !is_asked)
        return;
    const gl::StateGuard guard(parts.device, BLOCK_COUNT, IMAGE_COUNT,
                               parts.storages(state, settings));
    const Picture bound(parts, frame);
    if (empty && !is_asked)
        return;
    PreparedFrame prepared = parts.begin(state, frame, settings);
    Parts::check_host_fragments(state, prepared);
    transparent::SeenTransparents seen = parts.transparents.look(prepared);
    state.lists_have_hosts = false;
    parts.order_transparents(state, prepared, seen);
    if (!prepared.sees_media) {
        parts.draw_transparents(state, prepared, seen, nullptr);
        if (is_asked)
            state.publish_volume(nullptr, prepared);
        return;
    }
    parts.ask_depths(state, prepared, seen);
    prepared.fine_tiles = pass::fine_tiles(parts.tools, prepared);
    state.draw(prepared, parts.tools);
    parts.lay_media_over(*state.layers, prepared);
    parts.draw_transparents(state, prepared, seen, state.layers.get());
    if (is_asked)
        state.publish_volume(state.layers.get(), prepared);
    parts.last_history = view.history();
}

void Renderer::begin_transparents(View& view, const Frame& frame, const FrameSettings& settings,
                                  const TransparentBindings& bindings)
{
    check(frame, settings);
    Parts& parts = *parts_;
    View::State& state = parts.state_of(view);
    if (state.host_fragments && state.host_fragments->bindings != nullptr)
        throw Error("begin_transparents: the view's last draws have not ended; call "
                    "end_transparents() after them");
    parts.show_what_came();
    const PreparedFrame prepared =
        prepare_frame(frame, settings, parts.frame_scene(), parts.past_of(state, frame));
    auto guard = std::make_unique<gl::BindingGuard>(
        parts.device, gl::BindingGuard::Points{bindings.block,
                                               bindings.depth_unit,
                                               bindings.lists_image,
                                               {bindings.first_buffer, bindings.first_buffer + 1}});
    parts.begin_lists(state, prepared);
    state.host_fragments->bindings = std::move(guard);
    if (state.host_block.id() == 0)
        state.host_block = {parts.device, "host's transparents"};
    state.host_block.write(host_params(prepared, parts.transparents.size()));
    parts.device->BindBufferBase(GL_UNIFORM_BUFFER, bindings.block, state.host_block.id());
    gl::bind_texture(parts.device, bindings.depth_unit, frame.depth);
    parts.device->BindSampler(bindings.depth_unit, parts.depth_sampler.id());
    state.lists->bind(bindings.lists_image, bindings.first_buffer);
    state.lists->bind_framebuffer();
}

void Renderer::end_transparents(View& view)
{
    View::State& state = parts_->state_of(view);
    if (!state.host_fragments || state.host_fragments->bindings == nullptr)
        throw Error("end_transparents: no draws were begun; call begin_transparents() of the same "
                    "view before them");
    state.lists->let_read();
    state.host_fragments->bindings.reset();
}

InspectionLegend Renderer::inspect(View& view, const Frame& frame, const FrameSettings& settings,
                                   const Inspection& inspection)
{
    check(frame, settings);
    Parts& parts = *parts_;
    parts.show_what_came();
    const auto timed = parts.timers.frame(frame.index);
    View::State& state = parts.state_of(view);
    const gl::StateGuard guard(parts.device, BLOCK_COUNT, IMAGE_COUNT,
                               parts.storages(state, settings));
    const Picture picture(parts, frame);
    const PreparedFrame prepared = parts.begin(state, frame, settings);
    Parts::check_host_fragments(state, prepared);
    if (!state.holds(prepared))
        state.drawn.reset();
    const bool listed = inspection.kind == Inspection::Kind::layers &&
                        parts.list_transparents(state, prepared, parts.transparents.look(prepared));
    const auto draw_counts = [&] {
        parts.transparent_painter.draw_counts(parts.tools, listed ? state.lists.get() : nullptr);
    };
    InspectionLegend legend =
        resolve::inspect(parts.tools, state.layers_for(prepared.settings.mode, parts.tools),
                         parts.picture, prepared, inspection, draw_counts);
    state.host_fragments.reset();
    parts.last_history = view.history();
    parts.coming.end_frame();
    return legend;
}

LayerTextures Renderer::layers(View& view, const Frame& frame, const FrameSettings& settings)
{
    check(frame, settings);
    Parts& parts = *parts_;
    View::State& state = parts.state_of(view);
    if (parts.media.empty())
        return {};
    const gl::StateGuard guard(parts.device, BLOCK_COUNT, IMAGE_COUNT,
                               parts.storages(state, settings));
    const PreparedFrame prepared = parts.begin(state, frame, settings);
    if (!prepared.sees_media)
        return {};
    if (!state.holds(prepared))
        throw Error("the view holds no layers of such a frame: its last one was of another size or "
                    "had other settings; call composite() with this one first");
    return state.full_size(prepared, parts.tools);
}

LayerImages Renderer::read_layers(View& view, const Frame& frame, const FrameSettings& settings)
{
    View::State& state = parts_->state_of(view);
    const bool held = static_cast<bool>(state.full_scattering);
    const LayerTextures textures = layers(view, frame, settings);
    const glm::ivec2 size(frame.color.size);
    const std::size_t values =
        3 * static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
    if (!textures)
        return {std::vector<float>(values, 0.0f), std::vector<float>(values, 1.0f)};
    const gl::Device& gl = parts_->device;
    LayerImages images{gl::read_texture(gl, textures.scattering, 3),
                       gl::read_texture(gl, textures.transmittance, 3)};
    if (!held)
        state.drop_full_size();
    return images;
}

TransparentImages Renderer::read_transparents(View& view, const Frame& frame,
                                              const FrameSettings& settings)
{
    check(frame, settings);
    Parts& parts = *parts_;
    View::State& state = parts.state_of(view);
    if (parts.transparents.empty() && !state.lists_have_hosts)
        return {};
    const gl::StateGuard guard(parts.device, BLOCK_COUNT, IMAGE_COUNT,
                               parts.storages(state, settings));
    PreparedFrame prepared = parts.begin(state, frame, settings);
    transparent::SeenTransparents seen = parts.transparents.look(prepared);
    if (seen.list.empty() && !state.lists_have_hosts) {
        const auto values = 3 * static_cast<std::size_t>(prepared.picture_size.x) *
                            static_cast<std::size_t>(prepared.picture_size.y);
        return {std::vector<float>(values, 0.0f), std::vector<float>(values, 1.0f)};
    }
    parts.order_transparents(state, prepared, seen);
    if ((!seen.in_order && state.lists == nullptr) ||
        (prepared.sees_media && !state.holds(prepared)))
        throw Error("the view holds no transparents of such a frame: its last one was of another "
                    "size or had other settings; call composite() with this one first");
    gl::Framebuffer host(parts.device, "host's picture");
    host.attach_color({prepared.picture()});
    const gl::TextureView picture = parts.picture_behind(state, prepared, host, prepared.picture());
    const gl::Texture texture =
        gl::Texture::make_2d(parts.device, "what transparents did", prepared.picture_size,
                             GL_RGBA32F, gl::Filter::nearest);
    gl::Framebuffer framebuffer(parts.device, "what transparents did");
    framebuffer.attach_color({texture.view()});
    const auto read = [&](float nothing, GLenum of_added, bool needs_media) {
        const std::array<GLfloat, 4> value{nothing, nothing, nothing, 1};
        parts.device->ClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 0, value.data());
        const transparent::Resolved resolved{
            framebuffer, picture, of_added, parts.reads_picture(state), true, true};
        resolve::Layers* const layers =
            prepared.sees_media && needs_media ? state.layers.get() : nullptr;
        if (seen.in_order)
            parts.lay_in_order(state, prepared, seen, layers, resolved);
        else
            parts.transparent_painter.resolve(parts.tools, *state.lists, state.media_mask, layers,
                                              resolved, prepared);
        return gl::read_texture(parts.device, texture.view(), 3);
    };
    TransparentImages images;
    images.added = read(0, GL_ONE, true);
    // By factors of their own alone, whatever the media do.
    images.kept = read(1, GL_ZERO, parts.reads_picture(state));
    return images;
}

namespace {

/// SampleCounts::even_4 of squares of that edge.
double evenness(const std::vector<float>& counts, glm::ivec2 size, int edge)
{
    double all = 0, longest = 0;
    for (int y = 0; y < size.y; y += edge)
        for (int x = 0; x < size.x; x += edge) {
            const glm::ivec2 end = glm::min(glm::ivec2(x, y) + edge, size);
            float most = 0;
            for (int row = y; row < end.y; ++row)
                for (int column = x; column < end.x; ++column) {
                    const float count =
                        counts[static_cast<std::size_t>(row) * static_cast<std::size_t>(size.x) +
                               static_cast<std::size_t>(column)];
                    all += static_cast<double>(count);
                    most = std::max(most, count);
                }
            longest += static_cast<double>(most) * (end.x - x) * (end.y - y);
        }
    return longest > 0 ? all / longest : 0;
}

}  // namespace

SampleCounts Renderer::sample_counts(View& view, const Frame& frame, const FrameSettings& settings)
{
    check(frame, settings);
    Parts& parts = *parts_;
    View::State& state = parts.state_of(view);
    if (parts.media.empty())
        return {};
    const gl::StateGuard guard(parts.device, BLOCK_COUNT, IMAGE_COUNT,
                               parts.storages(state, settings));
    const PreparedFrame prepared = parts.begin(state, frame, settings);
    if (!prepared.sees_media)
        return {};
    if (!state.holds(prepared))
        state.drawn.reset();
    pass::VolumePass& pass = state.layers_for(prepared.settings.mode, parts.tools).pass();
    const gl::Texture counted = pass.sample_counts(prepared);
    const std::vector<float> counts = counted.read(1);
    SampleCounts found{.all = std::accumulate(counts.begin(), counts.end(), 0.0)};
    if (prepared.settings.mode == Settings::Mode::raymarch) {
        found.even_4 = evenness(counts, counted.size(), 4);
        found.even_8 = evenness(counts, counted.size(), 8);
    }
    return found;
}

void Renderer::draw_surfaces(const Frame& frame, const FrameSettings& settings, bool through_media)
{
    check(frame, settings);
    parts_->show_what_came();
    const auto time = parts_->timers.scope(through_media ? "surfaces through media" : "surfaces");
    parts_->draw_surfaces(frame, settings, through_media);
    parts_->surfaces_are_drawn = true;
}

void Renderer::Parts::draw_surfaces(const Frame& frame, const FrameSettings& s, bool through_media,
                                    const std::vector<bool>& unseen)
{
    const bool dimmed =
        through_media && scene_settings.volume_shadows && !media.empty() && lights.count() > 0;
    const gl::StateGuard guard(device, BLOCK_COUNT, IMAGE_COUNT);
    const PreparedFrame view = prepare_frame(frame, surface::surface_settings(s), frame_scene());
    if (dimmed)
        tools.check_loops(1, view.settings.shadow_steps);
    tools.bind_block(view);
    const Eye& eye = view.eye;
    lights.bind(eye.position);
    if (dimmed) {
        media.bind(eye.position);
        volumes.bind(eye.position, eye.forward, eye.perspective, media);
    }
    volumes.bind_for_surfaces(eye.position, through_media);
    probes.bind(eye.position);
    surface_painter.draw(tools, surfaces, view, dimmed, unseen);
}

void Renderer::Parts::lay_media_over(resolve::Layers& layers, const PreparedFrame& prepared)
{
    const resolve::Canvas canvas =
        resolve::make_canvas(tools, picture, prepared.picture(), prepared.settings);
    resolve::composite(tools, layers, canvas, prepared);
    last_passes = canvas.image                        ? "compute shaders"
                  : tools.computes(prepared.settings) ? "compute shaders, but the resolve by "
                                                        "fragments: the picture's format is none "
                                                        "of an image's"
                                                      : "fragments";
}

void Renderer::Parts::draw_media(View::State& view, const Frame& frame, const FrameSettings& s)
{
    if (media.empty())
        return;
    const gl::StateGuard guard(device, BLOCK_COUNT, IMAGE_COUNT, storages(view, s));
    const Picture target(*this, frame);
    const PreparedFrame prepared = begin(view, frame, s);
    if (!prepared.sees_media)
        return;
    view.draw(prepared, tools);
    lay_media_over(*view.layers, prepared);
}

void Renderer::update_probes(bool anew)
{
    parts_->captures.capture_all(anew);
}

std::vector<ProbeState> Renderer::probes() const
{
    return parts_->probes.states();
}

void Renderer::draw_probes(const Frame& frame, const FrameSettings& settings, double radius)
{
    check(frame, settings);
    Parts& parts = *parts_;
    if (parts.probes.ready() == 0)
        return;
    const gl::StateGuard guard(parts.device, BLOCK_COUNT, IMAGE_COUNT);
    const Picture picture(parts, frame);
    const PreparedFrame prepared =
        prepare_frame(frame, surface::surface_settings(settings), parts.frame_scene());
    parts.tools.bind(prepared);
    parts.probes.bind(prepared.eye.position);
    if (parts.probe_balls.id() == 0)
        parts.probe_balls = {parts.device, "probes as balls"};
    shared::InspectParams params{};
    params.plane_axis = glm::vec3(prepared.eye.world_from_view[0]);
    params.plane_place = static_cast<float>(radius);
    parts.probe_balls.write(params);
    parts.device->BindBufferBase(GL_UNIFORM_BUFFER, INSPECT_BLOCK, parts.probe_balls.id());
    parts.picture.bind(prepared.picture_size);
    parts.device->ColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
    parts.tools.draw_fullscreen("pass/probe_balls.frag", {});
}

std::string Renderer::probe_placement() const
{
    return parts_->probes.placement();
}

std::optional<double> Renderer::probes_next_turn() const
{
    return parts_->captures.next_turn();
}

std::vector<std::string> Renderer::explain(const FrameSettings& settings) const
{
    const auto surfaces = static_cast<int>(parts_->surfaces.instances().size());
    std::vector<std::string> lines =
        fumarole::explain(parts_->tools, surfaces, settings, parts_->last_layer);
    for (std::string& line : parts_->probes.describe())
        lines.push_back(std::move(line));
    if (const auto added = probes_next_turn())
        lines.push_back(fmt::format("probes: captured in two turns, a third would add {:.2g} % of "
                                    "what they have seen",
                                    100 * *added));
    if (!parts_->transparents.empty() || parts_->last_lists.lock() != nullptr)
        lines.push_back(parts_->explain_transparents(settings));
    return lines;
}

const medium::MediaTraits& Renderer::media_traits() const
{
    return parts_->media.traits();
}

Bounds Renderer::media_bounds() const
{
    return parts_->media.bounds();
}

void Renderer::prepare(const Frame& frame, const FrameSettings& settings)
{
    check(frame, settings);
    Parts& parts = *parts_;
    parts.finish_sending();
    const gl::Texture color =
        gl::Texture::make_2d(parts.device, "prepared picture", kPreparedSize,
                             parts.prepared_format(frame, settings), gl::Filter::nearest);
    const gl::Texture depth = gl::Texture::make_2d(parts.device, "prepared depth", kPreparedSize,
                                                   GL_DEPTH_COMPONENT32F, gl::Filter::nearest);
    const Bounds media = parts.media.bounds();
    const Eye eye = prepare_frame(frame, settings, parts.frame_scene()).eye;
    // Amid the media, whatever the frame sees, and a little further: a view that has moved.
    const auto look_from = [&](double part) {
        glm::dvec3 p = eye.position;
        if (!media.empty())
            p = glm::mix(media.min, media.max, part) - eye.forward * eye.near;
        Frame small = frame;
        small.color = color.view();
        small.depth = depth.view();
        small.view_from_world = glm::translate(glm::dmat4(glm::transpose(eye.world_from_view)), -p);
        small.target = {};
        if (!frame.transparents.empty())
            small.transparents = {TransparentExtent{}};
        return small;
    };
    Frame still = look_from(0.5), moved = look_from(0.51);
    const Parts::Preparing preparing(parts);
    parts.captures.prepare();
    // With probes, and without, as long as none is captured.
    for (const bool with_probes : {true, false}) {
        parts.probes.set_preparing(with_probes && parts.probes.count() > 0);
        for (const bool through_media : {false, true})
            parts.draw_surfaces(still, settings, through_media);
        surface::SurfacePainter::prepare(parts.tools, parts.surfaces);
    }
    View view = make_view();
    std::vector<int> scales{settled(view, still, settings).resolution};
    if (settings.mode == FrameSettings::Mode::raymarch && settings.resolution == kAutomatic)
        scales = {2, 4};
    for (const int scale : scales) {
        FrameSettings s = settings;
        s.resolution = scale;
        bool with_hosts = !frame.transparents.empty();  // once, as they are laid over alike
        const auto draw = [&](const Frame& one) {
            if (std::exchange(with_hosts, false))
                parts.begin_lists(parts.state_of(view), prepare_frame(one, s, parts.frame_scene()));
            composite(view, one, s);
            ++still.index;
            ++moved.index;
        };
        for (const Frame* one : {&still, &still, &moved})
            draw(*one);
        using Way = Parts::Way;
        for (const Way way : {Way::lists, Way::in_order, Way::at_panes, Way::as_panes})
            if (parts.may_lay(way)) {
                parts.prepares_way = way;
                draw(moved);
                parts.prepares_way.reset();
            }
        if (s.keeps_history())
            parts.draw_changes(view, draw, still, moved);
        view.reset_history();
    }
}

void Renderer::wait_until_ready()
{
    parts_->finish_sending();
    if (parts_->lights.shaded_media())
        parts_->lights.wait_for_sun_shadows();
    parts_->device->Finish();
}

void Renderer::set_timing(Timing timing)
{
    parts_->timers.set_timing(timing);
}

Timing Renderer::timing() const
{
    return parts_->timers.timing();
}

Timing Renderer::measuring_timing() const
{
    return gl::measuring_timing(parts_->device);
}

FrameReport Renderer::take_report()
{
    FrameReport report;
    report.timing = parts_->timers.timing();
    if (auto times = parts_->timers.take()) {
        report.pass_ms = std::move(times->passes);
        report.timed_frame = times->index;
    }
    report.gpu_bytes = parts_->device.bytes();
    report.allocations = parts_->device.allocations();
    report.history = parts_->last_history;
    report.passes = parts_->last_passes;
    report.transparents = fragment_count();
    report.uploading = parts_->coming.waits();
    report.uploaded_bytes = parts_->media.sent_bytes() -
                            std::exchange(parts_->reported_bytes, parts_->media.sent_bytes());
    const SceneWork before = std::exchange(parts_->reported, parts_->work());
    const SceneWork& now = parts_->reported;
    report.work = {now.grids_uploaded - before.grids_uploaded,
                   now.meshes_uploaded - before.meshes_uploaded,
                   now.shadow_views - before.shadow_views,
                   now.extinctions - before.extinctions,
                   now.depth_layers - before.depth_layers,
                   now.world_volumes - before.world_volumes,
                   now.fields - before.fields,
                   now.probes - before.probes,
                   now.lattices - before.lattices,
                   now.fires - before.fires};
    return report;
}

FragmentCount Renderer::fragment_count() const
{
    const auto lists = parts_->last_lists.lock();
    if (lists == nullptr)
        return {};
    const transparent::FragmentLists::Count count = lists->count();
    return {count.fragments, count.lost};
}

const gl::Device& Renderer::device() const
{
    return parts_->device;
}

}  // namespace fumarole
