#include "light/shadow_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <tuple>

namespace fumarole::light {

namespace {

/// Two unit vectors square to n and to each other.
std::pair<glm::dvec3, glm::dvec3> basis(glm::dvec3 n)
{
    const glm::dvec3 helper = std::abs(n.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    const glm::dvec3 right = glm::normalize(glm::cross(helper, n));
    return {right, glm::cross(n, right)};
}

/// World to a camera at `position` that looks along `forward` (its -z).
glm::dmat4 view_matrix(glm::dvec3 position, glm::dvec3 forward)
{
    const auto [right, up] = basis(-forward);
    glm::dmat4 view(1.0);
    for (int i = 0; i < 3; ++i) {
        view[i][0] = right[i];
        view[i][1] = up[i];
        view[i][2] = -forward[i];
    }
    return view * glm::translate(glm::dmat4(1.0), -position);
}

View perspective_view(glm::dvec3 position, glm::dvec3 forward, double tangent, double range,
                      int map_size)
{
    View view;
    view.origin = position;
    view.range = range;
    view.bias = 1.5 * 2 * tangent / map_size;
    view.clip_from_world = glm::perspective(2 * std::atan(tangent), 1.0, range * 1e-6, range) *
                           view_matrix(position, forward);
    return view;
}

shared::ShadowDepth depth_of(const View& view, glm::dvec3 eye)
{
    shared::ShadowDepth out{};
    out.origin = glm::vec3(view.origin - eye);
    out.inverse_range = static_cast<float>(1 / view.range);
    out.travel = glm::vec3(view.axis);
    out.bias = static_cast<float>(view.bias);
    return out;
}

/// Whether boxes have a place in common, of more than a face.
bool overlap(const Bounds& a, const Bounds& b)
{
    return glm::all(glm::lessThan(a.min, b.max)) && glm::all(glm::lessThan(b.min, a.max));
}

}  // namespace

LightAxes::LightAxes(glm::dvec3 to_light) : travel{-glm::normalize(to_light)}
{
    std::tie(right, up) = basis(-travel);
    for (int i = 0; i < 3; ++i) {
        light_from_world[i][0] = right[i];
        light_from_world[i][1] = up[i];
        light_from_world[i][2] = travel[i];
    }
}

bool is_detail(const surface::SurfaceSet::Instance& instance, const Bounds& media)
{
    constexpr double kLarge = 4;  // times the media
    return instance.bounds.diagonal() <= kLarge * media.diagonal();
}

bool can_shade(const LightPosition& light, const Bounds& surface, const Bounds& media)
{
    // What lies between the media and the light, as a box along the world's axes.
    Bounds between = media;
    if (!light.far) {
        between.add(light.at);
        return overlap(between, surface);
    }
    for (int axis = 0; axis < 3; ++axis) {
        constexpr double kFar = std::numeric_limits<double>::infinity();
        if (light.at[axis] > 0)
            between.max[axis] = kFar;
        else if (light.at[axis] < 0)
            between.min[axis] = -kFar;
    }
    // And along the light's, whose z it fills from the media's far side on.
    const LightAxes axes(light.at);
    Bounds column = media.transformed(axes.light_from_world);
    column.min.z = -std::numeric_limits<double>::infinity();
    return overlap(between, surface) && overlap(column, surface.transformed(axes.light_from_world));
}

Bounds outside_of_boxes(Bounds media, std::span<const surface::SurfaceSet::Instance> surfaces)
{
    for (const auto& instance : surfaces) {
        const Bounds& box = instance.bounds;
        if (!instance.is_box || media.empty())
            continue;
        const auto goes_across = [&](int axis) {
            return box.min[axis] <= media.min[axis] && box.max[axis] >= media.max[axis];
        };
        for (int axis = 0; axis < 3; ++axis) {
            if (!goes_across((axis + 1) % 3) || !goes_across((axis + 2) % 3))
                continue;
            if (box.min[axis] <= media.min[axis])
                media.min[axis] = std::max(media.min[axis], box.max[axis]);
            else if (box.max[axis] >= media.max[axis])
                media.max[axis] = std::min(media.max[axis], box.min[axis]);
            if (media.min[axis] >= media.max[axis])
                return {};
        }
    }
    return media;
}

bool can_shade_surfaces(std::span<const LightPosition> lights,
                        std::span<const surface::SurfaceSet::Instance> surfaces)
{
    constexpr std::size_t kMany = 16;  // among which some will
    if (surfaces.size() > kMany)
        return true;
    return std::any_of(surfaces.begin(), surfaces.end(), [&](const auto& caster) {
        // What is closed is a ball or a box, and none of it lies before another part of it.
        return !caster.closed ||
               std::any_of(surfaces.begin(), surfaces.end(), [&](const auto& other) {
                   return &other != &caster &&
                          std::any_of(lights.begin(), lights.end(), [&](const auto& light) {
                              return can_shade(light, caster.bounds, other.bounds);
                          });
               });
    });
}

View parallel_view(const LightAxes& axes, const Bounds& covered, const Bounds& casters,
                   int map_size)
{
    const glm::dvec2 centre = glm::dvec2(covered.min + covered.max) / 2.0;
    // Two texels of rim stay clear of casters, so a lookup past the edge finds light.
    const glm::dvec2 half =
        glm::dvec2(covered.max - covered.min) / 2.0 * (1 + 6.0 / map_size) + 1e-9;
    View view;
    view.axis = axes.travel;
    view.range = std::max(casters.max.z - casters.min.z, 1e-9) * 1.01;
    const double first = casters.min.z - 0.005 * view.range;
    view.origin = axes.right * centre.x + axes.up * centre.y + axes.travel * first;
    view.bias = 1.5 * 2 * std::max(half.x, half.y) / map_size;
    // Depth is written by the shader, so clip z is 0 all along.
    glm::dmat4 clip_from_light(0.0);
    clip_from_light[0][0] = 1 / half.x;
    clip_from_light[1][1] = 1 / half.y;
    clip_from_light[3] = glm::dvec4(-centre.x / half.x, -centre.y / half.y, 0, 1);
    view.clip_from_world = clip_from_light * axes.light_from_world;
    return view;
}

double point_view_tangent(int map_size)
{
    return 1 + 4.0 / std::max(map_size, 1);
}

std::vector<View> point_views(glm::dvec3 position, double range, int map_size)
{
    constexpr std::array<glm::dvec3, 6> kFaces{glm::dvec3(1, 0, 0), glm::dvec3(-1, 0, 0),
                                               glm::dvec3(0, 1, 0), glm::dvec3(0, -1, 0),
                                               glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1)};
    const double tangent = point_view_tangent(map_size);
    std::vector<View> views;
    views.reserve(kFaces.size());
    for (const glm::dvec3& face : kFaces)
        views.push_back(perspective_view(position, face, tangent, range, map_size));
    return views;
}

View spot_view(const SpotLight& spot, double range, int map_size)
{
    const double half = std::min(glm::radians(spot.cone_deg) / 2, glm::radians(89.0));
    return perspective_view(spot.position, glm::normalize(spot.direction),
                            std::tan(half) * (1 + 4.0 / map_size), range, map_size);
}

shared::ShadowView to_shared(const View& view, glm::dvec3 eye)
{
    shared::ShadowView out{};
    out.clip_from_world = glm::mat4(view.clip_from_world * glm::translate(glm::dmat4(1.0), eye));
    out.depth = depth_of(view, eye);
    return out;
}

gl::Texture ShadowPainter::make_map(std::size_t views, int map_size) const
{
    return gl::Texture::make_2d_array(device_, "shadow map",
                                      {map_size, map_size, static_cast<int>(views)},
                                      GL_DEPTH_COMPONENT32F, gl::Filter::depth_compare);
}

void ShadowPainter::draw(const gl::Texture& map, std::size_t layer, const View& view,
                         const surface::SurfaceSet& surfaces)
{
    if (!framebuffer_)
        framebuffer_ = {device_, "shadow map"};
    const glm::ivec2 size(map.size());
    const auto& all = surfaces.instances();
    const bool solids =
        std::any_of(all.begin(), all.end(), [](const auto& instance) { return instance.closed; });
    device_->BindBufferBase(GL_UNIFORM_BUFFER, DRAW_BLOCK, block_.id());
    device_->Enable(GL_DEPTH_TEST);
    device_->DepthMask(GL_TRUE);
    device_->DepthFunc(GL_LESS);
    if (solids) {
        if (!backs_ || glm::ivec2(backs_.size()) != size)
            backs_ = gl::Texture::make_2d(device_, "far sides in a shadow map", size,
                                          GL_DEPTH_COMPONENT32F, gl::Filter::nearest);
        framebuffer_.attach_depth(backs_.view());
        clear(size);
        device_->Enable(GL_CULL_FACE);
        device_->CullFace(GL_FRONT);
        draw_surfaces(view, surfaces, true, {});
        device_->Disable(GL_CULL_FACE);
        backs_.bind(SHADOW_MAP_UNIT);
    }
    framebuffer_.attach_depth_layer(map.view(), static_cast<int>(layer));
    clear(size);
    if (solids)
        draw_surfaces(view, surfaces, true, {{"kHalfway", ""}});
    draw_surfaces(view, surfaces, false, {});
    device_->Disable(GL_DEPTH_TEST);
    device_->DepthMask(GL_FALSE);
}

void ShadowPainter::clear(glm::ivec2 size)
{
    framebuffer_.bind(size);
    const GLfloat far = 1.0f;
    device_->ClearNamedFramebufferfv(framebuffer_.id(), GL_DEPTH, 0, &far);
}

void ShadowPainter::draw_surfaces(const View& view, const surface::SurfaceSet& surfaces,
                                  bool closed, const gl::Defines& variant)
{
    bool used = false;
    for (const auto& instance : surfaces.instances()) {
        if (instance.closed != closed)
            continue;
        if (!used)
            device_->UseProgram(
                programs_.get({"pass/surface.vert", "light/shadow_map.frag"}, variant).id());
        used = true;
        shared::DrawParams params{};
        params.clip_from_object = glm::mat4(view.clip_from_world * instance.world_from_object);
        params.world_from_object =
            glm::mat4(glm::translate(glm::dmat4(1.0), -view.origin) * instance.world_from_object);
        params.shadow_depth = depth_of(view, view.origin);
        block_.write(params);
        surfaces.draw(instance);
    }
}

}  // namespace fumarole::light
