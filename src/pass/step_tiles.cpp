#include "pass/step_tiles.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "light_fields.h"
#include "pass/point_shades.h"
#include "prepared_frame.h"

namespace fumarole::pass {

namespace {

/// Where a convex body is in the picture and in depth.
struct Projected {
    glm::dvec2 low{std::numeric_limits<double>::infinity()};  ///< pixels, from the lower left
    glm::dvec2 high{-std::numeric_limits<double>::infinity()};
    glm::dvec2 view_z{std::numeric_limits<double>::infinity(),
                      -std::numeric_limits<double>::infinity()};
};

Projected project_box(const Bounds& box, const glm::dmat4& view_from_box, const Frame& frame,
                      double near)
{
    const glm::dvec2 size(frame.color.size);
    Projected out;
    bool crosses = false;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec4 view = view_from_box * glm::dvec4(box.corner(i), 1.0);
        const double z = -view.z;
        out.view_z = {std::min(out.view_z.x, z), std::max(out.view_z.y, z)};
        const glm::dvec4 clip = frame.clip_from_view * view;
        if (!(z > near) || !(clip.w > 0)) {
            crosses = true;
            continue;
        }
        const glm::dvec2 pixel = (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * size;
        out.low = glm::min(out.low, pixel);
        out.high = glm::max(out.high, pixel);
    }
    if (crosses) {
        out.low = glm::dvec2(0);
        out.high = size;
    }
    const double margin =
        StepView::kDepthRounding * (std::abs(out.view_z.x) + std::abs(out.view_z.y));
    out.view_z += glm::dvec2(-margin, margin);
    return out;
}

/// Calls f(texel) for the tiles that low..high, in pixels, lies in.
template <class F>
void for_tiles(glm::dvec2 low, glm::dvec2 high, int pixels, glm::ivec2 count, F f)
{
    const auto tile = [&](glm::dvec2 at) {
        return glm::ivec2(glm::clamp(glm::floor(at / static_cast<double>(pixels)), glm::dvec2(-1),
                                     glm::dvec2(count)));
    };
    const glm::ivec2 first = glm::max(tile(low), 0);
    const glm::ivec2 last = glm::min(tile(high), count - 1);
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
            f(static_cast<std::size_t>(y) * static_cast<std::size_t>(count.x) +
              static_cast<std::size_t>(x));
}

/// What has the shaders over tiles of the march leave out the others.
gl::Defines tile_defines(const TilePart& which)
{
    const auto value = [](bool is) { return is ? "true" : "false"; };
    gl::Defines defines;
    if (which.lit)
        defines += {{"kAllTiles", "false"}, {"kLitTiles", value(*which.lit)}};
    if (which.far)
        defines += {{"kByDistance", "true"}, {"kFarTiles", value(*which.far)}};
    return defines;
}

/// Those that surfaces may hide from what a rectangle of the picture holds: along the view, where
/// that is in one part of what slots there are and in another, part by part.
std::uint32_t shaded_points(const PointShades& shades, const StepSlots& slots, std::uint64_t held,
                            glm::dvec2 ndc, glm::dvec2 reach, std::uint32_t among, int parts)
{
    const int first = std::countr_zero(held), end = 64 - std::countl_zero(held);
    const int part = (end - first + parts - 1) / parts;
    std::uint32_t shaded = 0;
    for (int i = first; i < end; i += part) {
        const int beyond = std::min(i + part, end);
        if ((held & StepSlots::row(i, beyond)) != 0)
            shaded |=
                shades.over(ndc, reach, {slots.begin(i), slots.begin(beyond)}, among & ~shaded);
    }
    return shaded;
}

constexpr std::size_t kGrain = 128;  // tiles or boxes for a thread at once

constexpr glm::uvec4 kEmptyTile(0), kDrawnTile(1, 0, 0, 0);
constexpr std::uint32_t kLitTile = 0x80000000u;  // shared::tile_is_lit()

}  // namespace

StepView StepTiles::view_of(const PreparedFrame& frame)
{
    StepView view(frame);
    const light::LightSet& lights = tools_.lights;
    for (const LightPosition& place : lights.points())
        if (!place.far)
            view.lights.emplace_back(place.at, frame.host, frame.eye.near);
    view.spaced = frame.settings.spacing == Settings::Spacing::medium && !lights.has_edges();
    view.lit = lights.shadow_views() > 0 && !lights.shaded_media();
    // Where other lights are shaded is not looked up. Grain as large as this would show.
    const bool shades = lights.shaded_media() || lights.filters().any();
    view.shafts_anywhere =
        lights.count() != lights.suns() && shades && frame.settings.resolution > 2;
    // Worth a program of its own where it saves much: one light is drawn as it always was.
    const auto points =
        std::count_if(lights.lights().begin(), lights.lights().end(),
                      [](const Light& light) { return std::holds_alternative<PointLight>(light); });
    if (points > 1 && frame.settings.falloff == Settings::Falloff::exact && !frame.fine)
        view.far_share = far_share(static_cast<double>(tools_.media.traits().most_g));
    return view;
}

void StepTiles::set(const PreparedFrame& frame)
{
    const auto tiles_of = [](glm::ivec2 pixels, int edge) { return (pixels + edge - 1) / edge; };
    march_.count = depth_.count = tiles_of(frame.layer_size, kLayerTile);
    picture_.count = tiles_of(frame.picture_size, kPictureTile);
    computes_ = tools_.computes(frame.settings);
    on_gpu_ = false;
    tells_far_ = false;
    if (frame.settings.range == Settings::Range::media) {
        const StepView view = view_of(frame);
        const bool suns_alone = tools_.lights.count() == tools_.lights.suns();
        tells_far_ = view.far_share > 0 && frame.settings.empty_space_skipping;
        // Or nothing comes of it.
        const bool asks_suns = frame.settings.empty_space_skipping && (view.spaced || suns_alone);
        if (asks_suns)
            tools_.sun_shades.set(tools_.lights, frame);
        asks_suns_ = asks_suns && tools_.sun_shades.any();
        if (computes_ && frame.prepares)
            boxes_.prepare();
        // Where a sun's shadows end, which tiles keep what they meet and which are fine, the CPU
        // knows alone.
        const DepthsAsked& asked = frame.depths_asked;
        on_gpu_ = computes_ && frame.settings.empty_space_skipping && !asks_suns_ &&
                  asked.areas.empty() && asked.view_z.empty() && frame.panes == 0 &&
                  frame.fine_tiles.empty();
        if (on_gpu_)
            set_on_gpu(frame, view);
        else
            set_on_cpu(frame, &view);
    } else {
        set_on_cpu(frame, nullptr);
    }
    if (computes_)
        list();
}

void StepTiles::set_on_gpu(const PreparedFrame& frame, const StepView& view)
{
    make_texture("tiles that march", march_);
    make_texture("tiles with depth", depth_);
    make_texture("tiles of the picture", picture_);
    boxes_.fill(view, march_.texture, depth_.texture, picture_.texture);
    for (const std::size_t lit : {0, 1})
        there_.at(lit) = {frame.prepares || view.lit == (lit != 0),
                          tells_far_ && (frame.prepares || view.lit == (lit != 0))};
}

void StepTiles::set_on_cpu(const PreparedFrame& frame, const StepView* view)
{
    const bool skip = view != nullptr && frame.settings.empty_space_skipping;
    for (Tiles* tiles : {&march_, &depth_, &picture_})
        tiles->texels.assign(static_cast<std::size_t>(tiles->count.x) *
                                 static_cast<std::size_t>(tiles->count.y),
                             skip ? kEmptyTile : kDrawnTile);
    if (skip) {
        see_media(*view);
        choose_steps(*view);
        want_depths(*view);
    } else if (view != nullptr) {
        std::fill(march_.texels.begin(), march_.texels.end(),
                  view->slots.tile({.slots = view->slots.all()}));
    }
    part(frame);
    mark_depths_asked(frame);
    for (const std::size_t lit : {0, 1})
        there_.at(lit) = {frame.prepares, frame.prepares && tells_far_};
    for (const glm::uvec4& tile : march_.texels)
        if (tile.x != 0)
            there_.at(StepSlots::is_lit(tile) ? 1 : 0).at(shared::tile_is_far(tile.w) ? 1 : 0) =
                true;
    upload("tiles that march", march_);
    upload("tiles with depth", depth_);
    upload("tiles of the picture", picture_);
}

void StepTiles::list()
{
    // Earlier frames' lists, and whatever reads, stores or is drawn to the targets of passes.
    tools_.device->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                                 GL_FRAMEBUFFER_BARRIER_BIT);
    const auto fill = [&](TileList& list, const Tiles& tiles, gl::Defines which) {
        which.emplace_back("kTilePixels", fmt::format("{}", tiles.pixels));
        list.fill(tools_, tiles.texture, which);
    };
    for (const std::size_t lit : {0, 1})
        for (const std::size_t far : {0, 1})
            if (there_.at(lit).at(far))
                fill(lists_.at(lit).at(far), march_, tile_defines({lit != 0, far != 0}));
    fill(depth_list_, depth_, {});
    fill(picture_list_, picture_, {});
    TileList::let_read(tools_);
}

void StepTiles::mark_depths_asked(const PreparedFrame& frame)
{
    constexpr double kTaps = 2;  // texels around a pixel that a lookup reads
    const double scale = frame.settings.resolution;
    const glm::dvec2 offset = frame.host.layer_offset - glm::dvec2(frame.layer_guard);
    for (const DepthsAsked::Area& area : frame.depths_asked.areas)
        for_tiles(area.low / scale - offset - kTaps, area.high / scale - offset + kTaps, kLayerTile,
                  march_.count, [&](std::size_t i) {
                      if (march_.texels[i].x == 0)
                          return;
                      march_.texels[i].w |= shared::kTileKeepsDepths;
                      depth_.texels[i].w = kLitTile;
                  });
}

void StepTiles::see_media(const StepView& view)
{
    const PreparedFrame& frame = view.frame;
    seen_.assign(march_.texels.size(), {});
    std::vector<Projected> projected;
    for (const medium::Occupied& part : tools_.media.occupied()) {
        const glm::dmat4 view_from_box = frame.host.view_from_world * part.world_from_box;
        projected.resize(part.boxes.size());
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, part.boxes.size(), kGrain),
                          [&](const tbb::blocked_range<std::size_t>& range) {
                              for (std::size_t i = range.begin(); i < range.end(); ++i)
                                  projected[i] = project_box(part.boxes[i].bounds, view_from_box,
                                                             frame.host, frame.eye.near);
                          });
        for (std::size_t k = 0; k < projected.size(); ++k) {
            const Projected& box = projected[k];
            if (box.view_z.y <= frame.eye.near)
                continue;
            const float most = part.boxes[k].most;
            const float longest = longest_step(part.detail, static_cast<double>(most));
            const std::uint64_t held = view.slots.between(box.view_z.x, box.view_z.y);
            constexpr double kSlack = StepView::kSlack;
            for_tiles(box.low / view.scale - view.offset - kSlack,
                      box.high / view.scale - view.offset + kSlack, kLayerTile, march_.count,
                      [&](std::size_t i) {
                          Seen& tile = seen_[i];
                          tile.slots |= held;
                          tile.longest = std::min(tile.longest, longest);
                          tile.most = std::max(tile.most, most);
                      });
            const double grow = view.reach * view.scale + kSlack;
            for_tiles(box.low - grow, box.high + grow, kPictureTile, picture_.count,
                      [&](std::size_t i) { picture_.texels[i] = kDrawnTile; });
        }
    }
}

void StepTiles::part(const PreparedFrame& frame)
{
    if (frame.fine_tiles.empty())
        return;
    for (std::size_t i = 0; i < picture_.texels.size(); ++i)
        if (frame.fine_tiles[i] != frame.fine)
            picture_.texels[i] = kEmptyTile;
    if (!frame.fine)
        return;
    static_assert(kPictureTile % kLayerTile == 0);
    std::size_t i = 0;
    for (int y = 0; y < march_.count.y; ++y)
        for (int x = 0; x < march_.count.x; ++x, ++i) {
            const glm::ivec2 tile = glm::ivec2(x, y) * kLayerTile / kPictureTile;
            if (!frame.fine_tiles[static_cast<std::size_t>(tile.y * picture_.count.x + tile.x)])
                march_.texels[i] = depth_.texels[i] = kEmptyTile;
        }
}

void StepTiles::choose_steps(const StepView& view)
{
    const glm::dvec2 ndc_per_pixel = 2.0 / glm::dvec2(view.frame.picture_size);
    const double pixels = view.scale * double{kLayerTile};
    const bool suns_alone = tools_.lights.count() == tools_.lights.suns();
    std::optional<PointShades> shades;
    if (!view.lit && PointShades::can_tell(tools_.lights))
        shades.emplace(tools_.lights, view.frame);
    // Most lights are told of many tiles at once.
    constexpr int kBlock = 4;
    const glm::ivec2 blocks = (march_.count + (kBlock - 1)) / kBlock;
    const auto block_of = [&](glm::ivec2 tile) {
        return static_cast<std::size_t>(tile.y / kBlock * blocks.x + tile.x / kBlock);
    };
    if (shades) {
        std::vector<std::uint64_t> held(static_cast<std::size_t>(blocks.x) *
                                        static_cast<std::size_t>(blocks.y));
        for (int y = 0, i = 0; y < march_.count.y; ++y)
            for (int x = 0; x < march_.count.x; ++x, ++i)
                held[block_of({x, y})] |= seen_[static_cast<std::size_t>(i)].slots;
        shaded_blocks_.assign(held.size(), 0);
        for (int y = 0, i = 0; y < blocks.y; ++y)
            for (int x = 0; x < blocks.x; ++x, ++i) {
                const auto at = static_cast<std::size_t>(i);
                const glm::dvec2 pixel =
                    ((glm::dvec2(x, y) + 0.5) * double{kBlock * kLayerTile} + view.offset) *
                    view.scale;
                const glm::dvec2 reach = 0.5 * kBlock * pixels * ndc_per_pixel;
                if (held[at] != 0)
                    shaded_blocks_[at] =
                        shaded_points(*shades, view.slots, held[at], pixel * ndc_per_pixel - 1.0,
                                      reach, ~std::uint32_t{0}, 1);
            }
    }
    const auto choose = [&](std::size_t i) {
        const Seen& seen = seen_[i];
        const glm::dvec2 tile(i % static_cast<std::size_t>(march_.count.x),
                              i / static_cast<std::size_t>(march_.count.x));
        const glm::dvec2 pixel = ((tile + 0.5) * double{kLayerTile} + view.offset) * view.scale;
        StepSlots::Held held{.slots = seen.slots};
        if (asks_suns_)
            tools_.sun_shades.find(held, view.slots, pixel * ndc_per_pixel - 1.0,
                                   0.5 * pixels * ndc_per_pixel);
        if (view.shafts_anywhere)
            held.shafts = view.slots.all();
        if (tells_far_) {
            const auto z = [&](int slot) { return view.slots.begin(slot); };
            const glm::dvec2 range(z(std::countr_zero(seen.slots)),
                                   z(64 - std::countl_zero(seen.slots)));
            double nearest = std::numeric_limits<double>::infinity();
            for (const NearLight& light : view.lights)
                nearest = std::min(nearest, light.from_tile(pixel, view.tile_radius(), range));
            held.far_from = view.far_share * nearest;
        }
        if (view.spaced) {
            held.longest = static_cast<double>(seen.longest);
            // Light has detail of its own beside where it comes from.
            for (const NearLight& light : view.lights)
                held.longest = std::min(held.longest, light.from_ray(pixel));
            held.longest_in_shaft =
                std::min(held.longest, view.shaft() / static_cast<double>(seen.most));
        }
        const bool sunlit = asks_suns_ ? held.lit : tools_.lights.suns() == 0;
        if (shades) {
            held.shaded = shaded_blocks_[block_of(glm::ivec2(tile))];
            // Looked at closely where each counts, or where there may be none.
            const int last = 63 - std::countl_zero(seen.slots);
            const bool may_be_far = view.slots.length(last) <= held.far_from;
            if (held.shaded != 0 && (may_be_far || std::has_single_bit(held.shaded)))
                held.shaded =
                    shaded_points(*shades, view.slots, held.slots, pixel * ndc_per_pixel - 1.0,
                                  0.5 * pixels * ndc_per_pixel, held.shaded, 4);
        }
        held.lit = view.lit || (sunlit && (suns_alone || held.shaded == 0));
        march_.texels[i] = view.slots.tile(held);
    };
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, seen_.size(), kGrain),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                          for (std::size_t i = range.begin(); i < range.end(); ++i)
                              if (seen_[i].slots != 0)
                                  choose(i);
                      });
}

void StepTiles::want_depths(const StepView& view)
{
    auto tile = picture_.texels.begin();
    for (int y = 0; y < picture_.count.y; ++y)
        for (int x = 0; x < picture_.count.x; ++x) {
            if (*tile++ == kEmptyTile)
                continue;
            const glm::dvec2 low =
                glm::dvec2(x, y) * double{kPictureTile} / view.scale - view.offset;
            for_tiles(low - view.reach - 1.0, low + kPictureTile / view.scale + view.reach + 1.0,
                      kLayerTile, depth_.count,
                      [&](std::size_t i) { depth_.texels[i] = kDrawnTile; });
        }
}

void StepTiles::make_texture(const char* label, Tiles& tiles) const
{
    if (glm::ivec2(tiles.texture.size()) != tiles.count)
        tiles.texture = gl::Texture::make_2d(tools_.device, label, tiles.count, GL_RGBA32UI,
                                             gl::Filter::nearest);
}

void StepTiles::upload(const char* label, Tiles& tiles) const
{
    make_texture(label, tiles);
    tiles.texture.upload(GL_RGBA_INTEGER, GL_UNSIGNED_INT, tiles.texels.data());
}

void StepTiles::draw(const Tiles& tiles, const char* pass, gl::Defines defines,
                     const std::string& vertex_file) const
{
    const gl::Device& gl = tools_.device;
    defines.emplace_back("kTilePixels", fmt::format("{}", tiles.pixels));
    tiles.texture.bind(STEP_TILES_UNIT);
    const std::string fragment_file = fmt::format("{}.frag", pass);
    gl->UseProgram(tools_.programs.get({vertex_file, fragment_file}, defines).id());
    gl->BindVertexArray(tools_.fullscreen.id());
    // Whole tiles, so that the middle of each is in view.
    const glm::vec2 size(tiles.count * tiles.pixels);
    gl->ViewportIndexedf(0, 0, 0, size.x, size.y);
    gl->Enable(GL_PROGRAM_POINT_SIZE);
    gl->DrawArrays(GL_POINTS, 0, tiles.count.x * tiles.count.y);
    gl->Disable(GL_PROGRAM_POINT_SIZE);
}

void StepTiles::dispatch(const Tiles& tiles, const TileList& list, const char* pass,
                         gl::Defines defines) const
{
    defines.emplace_back("kTilePixels", fmt::format("{}", tiles.pixels));
    tiles.texture.bind(STEP_TILES_UNIT);
    tools_.device->UseProgram(tools_.programs.get({fmt::format("{}.comp", pass)}, defines).id());
    list.dispatch(tools_);
}

bool StepTiles::is_there(const TilePart& which) const
{
    for (const std::size_t lit : {0, 1})
        for (const std::size_t far : {0, 1})
            if (there_.at(lit).at(far) && which.lit.value_or(lit != 0) == (lit != 0) &&
                which.far.value_or(far != 0) == (far != 0))
                return true;
    return false;
}

void StepTiles::run(const TilePart& which, const char* pass, gl::Defines defines) const
{
    if (!computes_) {
        defines += tile_defines(which);
        draw(march_, pass, std::move(defines));
        return;
    }
    for (const std::size_t lit : {1, 0})
        for (const std::size_t far : {0, 1})
            if (there_.at(lit).at(far) && which.lit.value_or(lit != 0) == (lit != 0) &&
                which.far.value_or(far != 0) == (far != 0))
                dispatch(march_, lists_.at(lit).at(far), pass, defines);
}

void StepTiles::run_tiles(const char* pass, const gl::Defines& defines) const
{
    run({}, pass, defines);
}

void StepTiles::run_march(const char* pass, const gl::Defines& defines) const
{
    using Is = std::optional<bool>;
    const std::vector<Is> all{std::nullopt}, both{true, false};
    for (const Is lit : tools_.lights.shadow_views() > 0 ? both : all)
        for (const Is far : tells_far_ ? both : all) {
            const TilePart which{lit, far};
            if ((lit || far) && !is_there(which))
                continue;
            gl::Defines own = defines;
            if (lit.value_or(false))
                own.emplace_back("kSurfaceShadows", "false");  // surfaces are not asked
            if (far.value_or(false))
                own.emplace_back("kFarPoints", "");
            if (far.value_or(false) && !computes_)
                own.emplace_back("kShadedPoints", "");
            // Four fetches at once pay where the same place is asked of all lights.
            const bool packed = far.value_or(false) && tools_.volumes.depths().has_packed();
            if (packed) {
                own.emplace_back("kPackedDepths", "");
                tools_.volumes.depths().bind_packed();
            }
            run(which, pass, own);
            if (packed)
                tools_.volumes.depths().bind();
        }
}

void StepTiles::run_depth(const char* pass, const gl::Defines& defines) const
{
    if (computes_)
        dispatch(depth_, depth_list_, pass, defines);
    else
        draw(depth_, pass, defines);
}

void StepTiles::draw_depth(const char* pass, gl::Defines defines, bool keeps) const
{
    defines += {{"kAllTiles", "false"}, {"kLitTiles", keeps ? "true" : "false"}};
    draw(depth_, pass, std::move(defines));
}

std::vector<bool> StepTiles::keeps_depths() const
{
    std::vector<bool> all(march_.texels.size());
    std::transform(march_.texels.begin(), march_.texels.end(), all.begin(),
                   [](const glm::uvec4& tile) { return shared::tile_keeps_depths(tile.w); });
    return all;
}

void StepTiles::draw_picture(const char* pass, const gl::Defines& defines) const
{
    draw(picture_, pass, defines, fmt::format("{}.vert", pass));
}

void StepTiles::run_picture(const char* pass, const gl::Defines& defines, bool computes) const
{
    if (computes)
        dispatch(picture_, picture_list_, pass, defines);
    else
        draw(picture_, pass, defines);
}

}  // namespace fumarole::pass
