#include "light/fire_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/gtc/matrix_transform.hpp>
#include <tbb/parallel_for.h>

#include "gl/buffer.h"
#include "ray_range.h"
#include "shared/fire_cells.h"

namespace fumarole::light {

namespace {

/// Along the longest edge of what glows: nodes of what arrives, rays, and, one a voxel up to here,
/// nodes of what the media are there; and nodes along that of all media.
constexpr int kNodes = 20, kRays = 12, kFlameNodes = 64, kMediaNodes = 48;
constexpr int kFewestFlameNodes = 24;
/// Parts of that edge beyond it within which nodes are twice as far apart.
constexpr double kGrowth = 0.25;
/// And as far as there are nodes at least: from there on what glows is no larger than a point.
constexpr double kBeyond = 3;
/// Of the surfaces' lattice, towards whose faces glsl/scene/world_irradiance.glsl fades out.
constexpr double kRim = 0.3;
constexpr int kMostCount = 160;  // nodes along an axis

double longest(glm::dvec3 size)
{
    return std::max({size.x, size.y, size.z});
}

}  // namespace

FireLight::Box FireLight::make_box(const Bounds& bounds, int most)
{
    const glm::dvec3 size = glm::max(bounds.max - bounds.min, glm::dvec3(1e-9));
    const double spacing = longest(size) / (most - 1);
    return {bounds, glm::max(glm::ivec3(glm::ceil(size / spacing - 1e-6)) + 1, glm::ivec3(2))};
}

shared::LatticeParams FireLight::to_shared(const Box& box, glm::dvec3 eye)
{
    const glm::dvec3 size = glm::max(box.bounds.max - box.bounds.min, glm::dvec3(1e-9));
    const glm::dmat4 node_from_eye = glm::scale(glm::dmat4(1.0), glm::dvec3(box.count - 1) / size) *
                                     glm::translate(glm::dmat4(1.0), eye - box.bounds.min);
    shared::LatticeParams out{};
    out.node_from_world = glm::mat4(node_from_eye);
    out.world_from_node = glm::mat4(glm::inverse(node_from_eye));
    out.last = glm::vec3(box.count - 1);
    out.layers = 1;
    out.inverse_size = 1.0f / glm::vec3(box.count);
    out.spacing = static_cast<float>(longest(size / glm::dvec3(box.count - 1)));
    return out;
}

void FireLight::place(const medium::MediaSet::CarriedGlow& glow, const Bounds& media,
                      const Bounds& around, double voxel, const std::optional<glm::vec3>& color)
{
    color_ = color;
    constexpr double kMostSamples = 4;
    const double edge = longest(glow.bounds.max - glow.bounds.min);
    const double voxels = std::clamp(edge / voxel, 1.0, 1e6);
    flame_ = make_box(glow.bounds, std::clamp(static_cast<int>(std::ceil(voxels)) + 1,
                                              kFewestFlameNodes, kFlameNodes));
    samples_ = static_cast<int>(std::clamp(std::ceil(voxels / kFlameNodes), 1.0, kMostSamples));
    media_ = make_box(media, kMediaNodes);
    middle_ = 0.5 * (glow.bounds.min + glow.bounds.max);
    core_ = glm::max(0.5 * (glow.bounds.max - glow.bounds.min), glm::dvec3(1e-9));
    node_ = 2 * longest(core_) / kNodes;
    growth_ = 2 * longest(core_) * kGrowth;
    corner_ = around.min;
    const glm::dvec3 rim = kRim * (around.max - around.min);
    known_.min = around.min + rim;
    known_.max = around.max - rim;
    const glm::dvec3 beyond(kBeyond * edge);
    first_ = glm::dvec3(0);
    first_ = glm::ceil(-node_of(glm::min(around.min, glow.bounds.min - beyond)));
    const glm::dvec3 last = glm::ceil(node_of(glm::max(around.max, glow.bounds.max + beyond)));
    count_ = glm::min(glm::ivec3(last) + 1, glm::ivec3(kMostCount));
    // A box of even light is as wide as this about a quarter of its edges off its middle.
    constexpr double kOff = 0.25;
    const medium::Glow::Axes axes = glow.glow.axes();
    points_.clear();
    for (int i = 0; i < FIRE_POINTS; ++i) {
        const glm::dvec3 side(glm::ivec3(i & 1, i >> 1 & 1, i >> 2 & 1) * 2 - 1);
        points_.push_back(glow.glow.middle + axes.directions * (kOff * side * axes.edges));
    }
}

glm::dvec3 FireLight::node_of(glm::dvec3 p) const
{
    const glm::dvec3 from = p - middle_;
    const glm::dvec3 beyond = glm::max(glm::abs(from) - core_, glm::dvec3(0));
    const glm::dvec3 even =
        glm::min(glm::abs(from), core_) + growth_ * glm::log(1.0 + beyond / growth_);
    return first_ + glm::sign(from) * even / node_;
}

shared::FireParams FireLight::params(glm::dvec3 eye) const
{
    shared::FireParams out{};
    out.flame = to_shared(flame_, eye);
    out.media = to_shared(media_, eye);
    for (std::size_t i = 0; i < points_.size(); ++i)
        out.points[i] = glm::vec4(glm::vec3(points_[i] - eye), 0);
    out.middle = glm::vec3(middle_ - eye);
    out.inverse_node = static_cast<float>(1 / node_);
    out.core = glm::vec3(core_);
    out.growth = static_cast<float>(growth_);
    out.first = glm::vec3(first_);
    out.is_seen = 1;
    out.last = glm::vec3(count_ - 1);
    out.rays = kRays;
    out.extinction_color = color_.value_or(glm::vec3(1));
    return out;
}

glm::dvec3 FireLight::place_of(glm::dvec3 node) const
{
    const glm::dvec3 from = (node - first_) * node_;
    const glm::dvec3 beyond = glm::max(glm::abs(from) - core_, glm::dvec3(0));
    const glm::dvec3 metres =
        glm::min(glm::abs(from), core_) + growth_ * (glm::exp(beyond / growth_) - 1.0);
    return middle_ + glm::sign(from) * metres;
}

std::optional<double> FireLight::seen_from(glm::dvec3 p, const surface::SurfaceSet& surfaces) const
{
    const auto is_in = [](const surface::SurfaceSet::Instance& one, glm::dvec3 q) {
        const glm::dvec3 half = 0.5 * (one.bounds.max - one.bounds.min);
        const glm::dvec3 from =
            (q - 0.5 * (one.bounds.min + one.bounds.max)) / glm::max(half, glm::dvec3(1e-9));
        return one.is_box ? glm::all(glm::lessThan(glm::abs(from), glm::dvec3(1)))
                          : glm::dot(from, from) < 1;
    };
    const auto hides = [](const surface::SurfaceSet::Instance& one, glm::dvec3 from,
                          glm::dvec3 to) {
        // What holds the fire is a room, or a ground, and not in its way.
        if (!one.is_box && glm::clamp(to, one.bounds.min, one.bounds.max) == to)
            return false;
        if (one.is_box) {
            const glm::dvec2 range = ray_range(from, to - from, one.bounds);
            return std::max(range.x, 0.0) < std::min(range.y, 1.0);
        }
        const glm::dvec3 half = glm::max(0.5 * (one.bounds.max - one.bounds.min), glm::dvec3(1e-9));
        const glm::dvec3 middle = 0.5 * (one.bounds.min + one.bounds.max);
        const glm::dvec3 a = (from - middle) / half, way = (to - from) / half;
        const double t = glm::clamp(-glm::dot(a, way) / glm::dot(way, way), 0.0, 1.0);
        return glm::dot(a + t * way, a + t * way) < 1;
    };
    double seen = 0;
    for (const auto& instance : surfaces.instances())
        if (instance.closed && is_in(instance, p))
            return {};
    for (const glm::dvec3& point : points_)
        seen += std::none_of(surfaces.instances().begin(), surfaces.instances().end(),
                             [&](const auto& one) { return hides(one, p, point); });
    return seen / static_cast<double>(points_.size());
}

gl::Texture FireLight::nodes_near(const surface::SurfaceSet& surfaces) const
{
    // Bits: whether light is asked for there; what is seen of the fire, times the next; 1 outside
    // of surfaces.
    constexpr std::uint32_t kNear = 1;
    constexpr int kSeen = 8, kOutside = 16;
    const auto index = [&](int x, int y, int z) {
        return static_cast<std::size_t>(x + count_.x * (y + count_.y * z));
    };
    std::vector<std::uint32_t> nodes(index(0, 0, count_.z));
    for (const auto& instance : surfaces.instances()) {
        // What is beyond the nodes looks up the last of them.
        const glm::dvec3 last(count_ - 1);
        const glm::dvec3 low = node_of(instance.bounds.min), high = node_of(instance.bounds.max);
        // A box's face with all that glows behind it has none of that.
        const glm::bvec3 is_high_dark = glm::greaterThan(instance.bounds.max, middle_ + core_),
                         is_low_dark = glm::lessThan(instance.bounds.min, middle_ - core_);
        glm::dvec3 inner_low = glm::ceil(low), inner_high = glm::floor(high);
        for (int axis = 0; axis < 3; ++axis) {
            if (is_low_dark[axis])
                inner_low[axis] -= 2;
            if (is_high_dark[axis])
                inner_high[axis] += 2;
        }
        const glm::ivec3 begin(glm::floor(glm::clamp(low, glm::dvec3(0), last))),
            end(glm::ceil(glm::clamp(high, glm::dvec3(0), last)));
        for (int z = begin.z; z <= end.z; ++z)
            for (int y = begin.y; y <= end.y; ++y)
                for (int x = begin.x; x <= end.x; ++x) {
                    const glm::dvec3 node(x, y, z);
                    const bool within = glm::all(glm::greaterThan(node, inner_low)) &&
                                        glm::all(glm::lessThan(node, inner_high));
                    if (!instance.is_box || !within)
                        nodes[index(x, y, z)] = kNear;
                }
    }
    tbb::parallel_for(0, count_.z, [&](int z) {
        for (int y = 0; y < count_.y; ++y)
            for (int x = 0; x < count_.x; ++x) {
                std::uint32_t& node = nodes[index(x, y, z)];
                const glm::dvec3 p = place_of({x, y, z});
                if (node == 0 || glm::clamp(p, known_.min, known_.max) == p)
                    continue;
                if (const std::optional<double> seen = seen_from(p, surfaces))
                    node |= static_cast<std::uint32_t>(std::lround(255 * *seen)) << kSeen |
                            255u << kOutside;
            }
    });
    gl::Texture texture = gl::Texture::make_3d(device_, "fire: nodes near surfaces", count_,
                                               GL_R32UI, gl::Filter::nearest);
    texture.upload(GL_RED_INTEGER, GL_UNSIGNED_INT, nodes.data());
    return texture;
}

void FireLight::dispatch(const char* file, const gl::Defines& defines, glm::ivec3 groups) const
{
    device_->UseProgram(programs_.get({file}, defines).id());
    device_->DispatchCompute(static_cast<GLuint>(groups.x), static_cast<GLuint>(groups.y),
                             static_cast<GLuint>(groups.z));
    device_->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                           GL_SHADER_STORAGE_BARRIER_BIT);
}

void FireLight::fill(const gl::Defines& media_defines, const surface::SurfaceSet& surfaces)
{
    const bool one_color = color_.has_value();
    gl::Defines of_media = media_defines;
    if (one_color)
        of_media.emplace_back("kOneColor", "");
    const GLenum extinction = one_color ? GL_R32F : GL_RGBA32F;
    const auto make = [&](const char* label, const Box& box, GLenum format) {
        return gl::Texture::make_3d(device_, label, box.count, format, gl::Filter::linear);
    };
    const auto bind_image = [&](GLuint unit, const gl::Texture& texture, GLenum format) {
        device_->BindImageTexture(unit, texture.id(), 0, GL_TRUE, 0, GL_WRITE_ONLY, format);
    };
    const auto groups_of = [](glm::ivec3 nodes) {
        return (nodes + VOLUME_GROUP - 1) / VOLUME_GROUP;
    };
    const gl::Texture in_flame = make("fire: extinction where it glows", flame_, extinction),
                      emission = make("fire: emission", flame_, GL_RGBA32F),
                      in_media = make("fire: extinction", media_, extinction);
    bind_image(0, in_media, extinction);
    dispatch("light/fire_medium.comp", of_media, groups_of(media_.count));
    bind_image(0, in_flame, extinction);
    bind_image(1, emission, GL_RGBA32F);
    of_media.emplace_back("kGlows", "");
    dispatch("light/fire_medium.comp", of_media, groups_of(flame_.count));

    const gl::Texture near = nodes_near(surfaces);
    const int cells = most_cells();
    struct Cell {
        glm::vec3 middle;
        std::uint32_t number;
    };
    const gl::Buffer list(device_, "fire: cells",
                          sizeof(glm::uvec4) + sizeof(Cell) * static_cast<std::size_t>(cells));
    const gl::Texture out = gl::Texture::make_2d(
        device_, "fire: what its cells let out",
        FIRE_TILE * glm::ivec2(FIRE_TILES, (cells + FIRE_TILES - 1) / FIRE_TILES), GL_RGBA32F,
        gl::Filter::linear);
    light_ = gl::Texture::make_3d(device_, "fire on surfaces", count_ * glm::ivec3(1, 1, 4),
                                  GL_RGBA16F, gl::Filter::linear);
    device_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, FIRE_CELLS_BUFFER, list.id());
    near.bind(FIELD_CROSSED_UNIT);
    in_flame.bind(FIELD_SIGMA_T_UNIT);
    emission.bind(FIELD_EMISSION_UNIT);
    in_media.bind(FIELD_ALBEDO_UNIT);
    out.bind(FIELD_SOURCE_UNIT);
    const gl::Defines kind{{"extinction_t", one_color ? "float" : "vec3"}};
    dispatch("light/fire_cells.comp", {}, glm::ivec3(1));
    bind_image(0, out, GL_RGBA32F);
    dispatch("light/fire_out.comp", kind, {cells, 1, 1});
    bind_image(0, light_, GL_RGBA16F);
    dispatch("light/fire_light.comp", kind, groups_of(count_));
}

int FireLight::most_cells() const
{
    // glsl/light/fire_cells.glsl
    const glm::ivec3 last = flame_.count - 1;
    const int longest = std::max({last.x, last.y, last.z});
    const int edge = 2 * ((longest + 2 * FIRE_CELLS - 1) / (2 * FIRE_CELLS));
    const glm::ivec3 cells = (last - 1) / edge + 1;
    return cells.x * cells.y * cells.z;
}

const gl::Texture& FireLight::make_seen(glm::ivec3 nodes)
{
    seen_ = gl::Texture::make_3d(device_, "fire that surfaces leave", nodes, GL_RGBA16F,
                                 gl::Filter::linear);
    return seen_;
}

void FireLight::move_to(glm::dvec3 corner)
{
    const glm::dvec3 by = corner - corner_;
    corner_ = corner;
    for (Bounds* bounds : {&flame_.bounds, &media_.bounds, &known_}) {
        bounds->min += by;
        bounds->max += by;
    }
    middle_ += by;
    for (glm::dvec3& point : points_)
        point += by;
}

void FireLight::clear()
{
    light_ = {};
    seen_ = {};
}

void FireLight::bind() const
{
    light_.bind(FIELD_ORDER_UNIT);
    seen_.bind(FIELD_WORLD_UNIT);
}

}  // namespace fumarole::light
