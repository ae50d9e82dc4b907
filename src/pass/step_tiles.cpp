#include "pass/step_tiles.h"

#include <algorithm>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "pass/frame_setup.h"

namespace fumarole::pass {

namespace {

constexpr float kNever = std::numeric_limits<float>::max();

/// How long a step may be [m] in a medium that changes within `detail` metres and extinguishes
/// `most` per metre: as long as its detail asks, or longer where there is next to nothing of it.
double longest_step(double detail, double most)
{
    constexpr double kDetail = 2;    // of what it changes within
    constexpr double kFaint = 0.02;  // optical depth of a step that changes are lost in
    constexpr double kThick = 0.3;   // that a step is to have at most
    return std::min(std::max(kDetail * detail, kFaint / most), kThick / most);
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

constexpr glm::vec4 kEmptyTile(kNever, -kNever, kNever, 0);
constexpr glm::vec4 kWholeTile(-kNever, kNever, 1, 1);

}  // namespace

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
                             skip ? kEmptyTile : kWholeTile);
    if (skip)
        project(frame);
    upload("tiles that march", march_);
    upload("tiles with depth", depth_);
    upload("tiles of the picture", picture_);
}

void StepTiles::project(const PassFrame& frame)
{
    const Settings& s = frame.settings;
    const double scale = s.resolution;
    const glm::dvec2 offset = frame.host.layer_offset - glm::dvec2(layer_guard(s));
    // Of the layer's texels that a pixel is made of, those on either side of it.
    const double reach = s.upsample == Settings::Upsample::bilinear2x2 ? 1 : 2;
    for (const medium::Occupied& part : tools_.media.occupied()) {
        const glm::dmat4 view_from_box = frame.host.view_from_world * part.world_from_box;
        for (const medium::OccupiedBox& box : part.boxes) {
            const Projected seen =
                project_box(box.bounds, view_from_box, frame.host, frame.eye.near);
            if (seen.view_z.y <= frame.eye.near)
                continue;
            const double longest = longest_step(part.detail, box.most);
            constexpr double kSlack = 0.01;  // texels, and pixels
            for_tiles(seen.low / scale - offset - kSlack, seen.high / scale - offset + kSlack,
                      kLayerTile, march_.count, [&](std::size_t i) {
                          glm::vec4& tile = march_.texels[i];
                          tile.x = std::min(tile.x, static_cast<float>(seen.view_z.x));
                          tile.y = std::max(tile.y, static_cast<float>(seen.view_z.y));
                          tile.z = std::min(tile.z, static_cast<float>(longest));
                          tile.w = 1;
                      });
            const double grow = reach * scale + kSlack;
            for_tiles(seen.low - grow, seen.high + grow, kPictureTile, picture_.count,
                      [&](std::size_t i) { picture_.texels[i] = kWholeTile; });
        }
    }
    for (glm::vec4& tile : march_.texels)
        tile.z = static_cast<float>(stride(frame, tile));
    for (int y = 0; y < picture_.count.y; ++y)
        for (int x = 0; x < picture_.count.x; ++x) {
            if (picture_.texels[static_cast<std::size_t>(y * picture_.count.x + x)].w == 0)
                continue;
            const glm::dvec2 low = glm::dvec2(x, y) * double{kPictureTile} / scale - offset;
            for_tiles(low - reach - 1.0, low + kPictureTile / scale + reach + 1.0, kLayerTile,
                      depth_.count, [&](std::size_t i) { depth_.texels[i] = kWholeTile; });
        }
}

// Splits that one step of a tile takes: of its steps, the last is the longest.
int StepTiles::stride(const PassFrame& frame, const glm::vec4& tile) const
{
    const Settings& s = frame.settings;
    // A spot's beam has an edge where the medium has none.
    if (s.spacing == Settings::Spacing::fixed || tile.w == 0 || tools_.lights.spots() > 0)
        return 1;
    const glm::dvec2 range = step_range(frame.eye, frame.media, s);
    const double end = std::min<double>(tile.y, range.y);
    const double lambda = frame.eye.perspective ? s.distribution : 0;
    // d z / d progress of the split (glsl/lib/step_lattice.glsl) is bent upwards: its chord from
    // the range's end stays under it.
    const double linear = range.y - range.x;
    const double bent = end * std::log(range.y / range.x);
    const double step = ((1 - lambda) * linear + (lambda > 0 ? lambda * bent : 0)) / s.steps;
    constexpr int kMost = 4;
    int stride = 1;
    while (stride < kMost && 2 * stride * step <= tile.z)
        stride *= 2;
    return stride;
}

void StepTiles::upload(const char* label, Tiles& tiles) const
{
    if (glm::ivec2(tiles.texture.size()) != tiles.count)
        tiles.texture = gl::Texture::make_2d(tools_.device, label, tiles.count, GL_RGBA32F,
                                             gl::Filter::nearest);
    tiles.texture.upload(GL_RGBA, GL_FLOAT, tiles.texels.data());
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
    defines.emplace_back("STEP_TILES", "");
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
