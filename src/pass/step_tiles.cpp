#include "pass/step_tiles.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "pass/frame_setup.h"

namespace fumarole::pass {

namespace {

/// How long a step may be [m] in a medium that changes within `detail` metres and extinguishes
/// `most` per metre: as long as its detail asks, or longer where there is next to nothing of it.
double longest_step(double detail, double most, bool shafts)
{
    constexpr double kDetail = 2;    // of what it changes within
    constexpr double kFaint = 0.02;  // optical depth of a step that changes are lost in
    constexpr double kThick = 0.3;   // that a step is to have at most
    constexpr double kShaft = 0.08;  // likewise: shafts of shadow change within any step
    return std::min(std::max(kDetail * detail, kFaint / most), (shafts ? kShaft : kThick) / most);
}

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
    // Rays and bricks are worked out by other sums on the GPU.
    const double margin = 1e-5 * (std::abs(out.view_z.x) + std::abs(out.view_z.y));
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

/// A light that has a place, beside the rays of a picture.
class NearLight {
public:
    NearLight(glm::dvec3 position, const Frame& frame, double near)
    {
        const glm::dvec4 view = frame.view_from_world * glm::dvec4(position, 1.0);
        const glm::dvec4 clip = frame.clip_from_view * view;
        least_ = glm::length(glm::dvec3(view));
        if (!(-view.z > near) || !(clip.w > 0))
            return;
        const glm::dvec2 size(frame.color.size);
        pixel_ = (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * size;
        metres_ = 2 * clip.w / (frame.clip_from_view[1][1] * size.y);
        least_ = 0;
    }

    /// Metres, about, between it and the ray of a pixel.
    [[nodiscard]] double from_ray(glm::dvec2 pixel) const
    {
        return std::max(least_, metres_ * glm::length(pixel - pixel_));
    }

private:
    glm::dvec2 pixel_{0};
    double metres_ = 0;  ///< of a pixel, where the light is
    double least_ = 0;   ///< of a light behind the eye
};

constexpr glm::uvec4 kEmptyTile(0, 0, 0, 0);
constexpr glm::uvec4 kDrawnTile(1, 0, 0, 1);

}  // namespace

/// The steps' lattice, in up to 64 slots of a power of two of steps.
class StepTiles::Slots {
public:
    explicit Slots(const PassFrame& frame)
        : steps_{frame.settings.steps}, width_{power_of_two((steps_ + kMost - 1) / kMost)}
    {
        const glm::dvec2 range = step_range(frame.eye, frame.media, frame.settings);
        const double lambda = frame.eye.perspective ? frame.settings.distribution : 0;
        for (int i = 0; i < steps_ + width_; i += width_) {
            // glsl/lib/step_lattice.glsl
            const double progress = std::min(1.0, static_cast<double>(i) / steps_);
            const double bent = range.x * std::pow(range.y / range.x, lambda > 0 ? progress : 0);
            ends_.push_back(glm::mix(glm::mix(range.x, range.y, progress), bent, lambda));
            if (i > 0)
                lengths_.push_back((ends_.back() - ends_.end()[-2]) /
                                   std::min(width_, steps_ - i + width_));
        }
    }

    /// Of those that view_z from low to high lies in. Outside the range the first and the last.
    [[nodiscard]] std::uint64_t between(double low, double high) const
    {
        const auto first = std::upper_bound(ends_.begin() + 1, ends_.end() - 1, low);
        const auto last = std::lower_bound(first, ends_.end() - 1, high);
        const auto bits = [&](auto end) {
            return ~std::uint64_t{0} >> (63 - (end - ends_.begin() - 1));
        };
        return bits(last) & ~(bits(first) >> 1);
    }

    [[nodiscard]] std::uint64_t all() const { return between(ends_.front(), ends_.back()); }

    /// Texel of a tile whose steps in `slots` may be `longest` metres long; spaced: or are as they
    /// are.
    [[nodiscard]] glm::uvec4 tile(std::uint64_t slots, double longest, bool spaced) const
    {
        if (slots == 0)
            return kEmptyTile;
        const int first = std::countr_zero(slots), end = 64 - std::countl_zero(slots);
        const int fours = spaced ? joined_until(4, longest) : 0;
        const int twos = spaced ? joined_until(2, longest) : 0;
        const int begin = first * width_;
        int width = std::max(width_, begin < fours ? 4 : begin < twos ? 2 : 1);
        const auto base = [&] { return begin & -width; };
        while (end * width_ - base() > kTileSlots * width)
            width *= 2;
        std::uint32_t bits = 0;
        for (int i = first; i < end; ++i)
            if ((slots >> i & 1) != 0)
                bits |= 1u << ((i * width_ - base()) / width);
        return glm::uvec4(bits, base(), width, fours | twos << 16);
    }

private:
    static constexpr int kMost = 64;
    static constexpr int kTileSlots = 31;  ///< of 32: the shader looks for the end of a row of bits

    static int power_of_two(int least)
    {
        return static_cast<int>(std::bit_ceil(static_cast<unsigned>(least)));
    }

    /// Before which split of the lattice so many in one are no longer than `longest`: splits grow
    /// with depth.
    [[nodiscard]] int joined_until(int many, double longest) const
    {
        const auto end = std::partition_point(lengths_.begin(), lengths_.end(), [&](double length) {
            return many * length <= longest;
        });
        return static_cast<int>(end - lengths_.begin()) * width_ & -many;
    }

    int steps_, width_;
    std::vector<double> ends_;     ///< view_z [m], from the first slot's begin
    std::vector<double> lengths_;  ///< of a slot's splits [m]
};

void StepTiles::set(const PassFrame& frame)
{
    const auto tiles_of = [](glm::ivec2 pixels, int edge) { return (pixels + edge - 1) / edge; };
    const glm::ivec2 picture(frame.host.color.size);
    march_.count = depth_.count = tiles_of(layer_size(picture, frame.settings), kLayerTile);
    picture_.count = tiles_of(picture, kPictureTile);
    const bool skip = frame.settings.skip && frame.settings.range == Settings::Range::media;
    for (Tiles* tiles : {&march_, &depth_, &picture_})
        tiles->texels.assign(static_cast<std::size_t>(tiles->count.x) *
                                 static_cast<std::size_t>(tiles->count.y),
                             skip ? kEmptyTile : kDrawnTile);
    const Slots slots(frame);
    if (skip)
        project(frame, slots);
    else
        std::fill(march_.texels.begin(), march_.texels.end(), slots.tile(slots.all(), 0, false));
    upload("tiles that march", march_);
    upload("tiles with depth", depth_);
    upload("tiles of the picture", picture_);
}

void StepTiles::project(const PassFrame& frame, const Slots& slots)
{
    const Settings& s = frame.settings;
    const double scale = s.resolution;
    const glm::dvec2 offset = frame.host.layer_offset - glm::dvec2(layer_guard(s));
    // Of the layer's texels that a pixel is made of, those on either side of it.
    const double reach = s.upsample == Settings::Upsample::bilinear2x2 ? 1 : 2;
    struct Seen {
        std::uint64_t slots = 0;
        double longest = std::numeric_limits<double>::infinity();  ///< step [m]
    };
    std::vector<Seen> seen_in(march_.texels.size());
    const bool shafts = tools_.lights.suns() > 0 && tools_.lights.shadow_views() > 0;
    for (const medium::Occupied& part : tools_.media.occupied()) {
        const glm::dmat4 view_from_box = frame.host.view_from_world * part.world_from_box;
        for (const medium::OccupiedBox& box : part.boxes) {
            const Projected seen =
                project_box(box.bounds, view_from_box, frame.host, frame.eye.near);
            if (seen.view_z.y <= frame.eye.near)
                continue;
            const double longest = longest_step(part.detail, box.most, shafts);
            const std::uint64_t held = slots.between(seen.view_z.x, seen.view_z.y);
            constexpr double kSlack = 0.01;  // texels, and pixels
            for_tiles(seen.low / scale - offset - kSlack, seen.high / scale - offset + kSlack,
                      kLayerTile, march_.count, [&](std::size_t i) {
                          seen_in[i].slots |= held;
                          seen_in[i].longest = std::min(seen_in[i].longest, longest);
                      });
            const double grow = reach * scale + kSlack;
            for_tiles(seen.low - grow, seen.high + grow, kPictureTile, picture_.count,
                      [&](std::size_t i) { picture_.texels[i] = kDrawnTile; });
        }
    }
    std::vector<NearLight> lights;
    for (const Light& light : tools_.lights.lights())
        if (const auto* point = std::get_if<PointLight>(&light))
            lights.emplace_back(point->position, frame.host, frame.eye.near);
    // Light has detail of its own beside where it comes from.
    for (std::size_t i = 0; i < seen_in.size() && !lights.empty(); ++i) {
        const glm::dvec2 tile(i % static_cast<std::size_t>(march_.count.x),
                              i / static_cast<std::size_t>(march_.count.x));
        const glm::dvec2 pixel = ((tile + 0.5) * double{kLayerTile} + offset) * scale;
        for (const NearLight& light : lights)
            seen_in[i].longest = std::min(seen_in[i].longest, light.from_ray(pixel));
    }
    // A spot's beam has an edge where the medium has none.
    const bool spaced = s.spacing == Settings::Spacing::medium && tools_.lights.spots() == 0;
    std::transform(seen_in.begin(), seen_in.end(), march_.texels.begin(),
                   [&](const Seen& seen) { return slots.tile(seen.slots, seen.longest, spaced); });
    for (int y = 0; y < picture_.count.y; ++y)
        for (int x = 0; x < picture_.count.x; ++x) {
            if (picture_.texels[static_cast<std::size_t>(y * picture_.count.x + x)] == kEmptyTile)
                continue;
            const glm::dvec2 low = glm::dvec2(x, y) * double{kPictureTile} / scale - offset;
            for_tiles(low - reach - 1.0, low + kPictureTile / scale + reach + 1.0, kLayerTile,
                      depth_.count, [&](std::size_t i) { depth_.texels[i] = kDrawnTile; });
        }
}

void StepTiles::upload(const char* label, Tiles& tiles) const
{
    if (glm::ivec2(tiles.texture.size()) != tiles.count)
        tiles.texture = gl::Texture::make_2d(tools_.device, label, tiles.count, GL_RGBA32UI,
                                             gl::Filter::nearest);
    tiles.texture.upload(GL_RGBA_INTEGER, GL_UNSIGNED_INT, tiles.texels.data());
}

void StepTiles::draw(const Tiles& tiles, int pixels, const char* fragment_file,
                     gl::Defines defines) const
{
    const gl::Device& gl = tools_.device;
    defines.emplace_back("TILE_PIXELS", fmt::format("{}", pixels));
    gl->BindTextureUnit(STEP_TILES_UNIT, tiles.texture.id());
    gl->UseProgram(tools_.programs.get({"pass/tiles.vert", fragment_file}, defines).id());
    gl->BindVertexArray(tools_.fullscreen.id());
    // Whole tiles, so that the middle of each is in view.
    const glm::vec2 size(tiles.count * pixels);
    gl->ViewportIndexedf(0, 0, 0, size.x, size.y);
    gl->Enable(GL_PROGRAM_POINT_SIZE);
    gl->DrawArrays(GL_POINTS, 0, tiles.count.x * tiles.count.y);
    gl->Disable(GL_PROGRAM_POINT_SIZE);
}

void StepTiles::draw_march(const char* fragment_file, gl::Defines defines) const
{
    draw(march_, kLayerTile, fragment_file, std::move(defines));
}

void StepTiles::draw_depth(const char* fragment_file, gl::Defines defines) const
{
    draw(depth_, kLayerTile, fragment_file, std::move(defines));
}

void StepTiles::draw_picture(const char* fragment_file, gl::Defines defines) const
{
    draw(picture_, kPictureTile, fragment_file, std::move(defines));
}

}  // namespace fumarole::pass
