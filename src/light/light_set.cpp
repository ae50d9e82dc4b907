#include "light/light_set.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "errors.h"
#include "light/world_light.h"

namespace fumarole::light {

namespace {

/// Surfaces this many times larger than the media don't get a share of a sun's detailed view: a
/// ground would spread it over itself. They are in the outer view.
constexpr double kLargeSurface = 4;

static_assert(MAX_SHADOW_VIEWS >= 6 * MAX_LIGHTS, "a point light takes six views");

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

glm::vec3 intensity_of(const Light& light)
{
    if (const auto* sun = std::get_if<SunLight>(&light))
        return sun->irradiance;
    if (const auto* point = std::get_if<PointLight>(&light))
        return point->radiant_intensity;
    return std::get<SpotLight>(light).radiant_intensity;
}

/// Distance from a point to the farthest corner of a box.
double farthest(glm::dvec3 p, const Bounds& bounds)
{
    double far = 0;
    for (int i = 0; i < 8 && !bounds.empty(); ++i)
        far = std::max(far, glm::length(bounds.corner(i) - p));
    return far;
}

}  // namespace

void LightSet::set_world(const World& world)
{
    if (world.environment == nullptr) {
        environment_source_ = nullptr;
        irradiance_ = {};
        environment_ = {};
        world_radiance_ = world.radiance;
        return;
    }
    if (environment_source_ == world.environment && environment_scale_ == world.environment_scale)
        return;
    environment_source_ = world.environment;
    environment_scale_ = world.environment_scale;
    world_radiance_ = mean_radiance(*world.environment) * environment_scale_;

    const auto upload = [&](const char* label, Environment map) {
        for (glm::vec3& texel : map.radiance)
            texel *= environment_scale_;
        gl::Texture texture = gl::Texture::make_2d(device_, label, {map.width, map.height},
                                                   GL_RGBA32F, gl::Filter::linear);
        texture.upload(GL_RGB, GL_FLOAT, map.radiance.data());
        device_->TextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
        return texture;
    };
    irradiance_ = upload("irradiance", irradiance_map(*world.environment, 64, 32));
    environment_ = upload("environment", *world.environment);
}

void LightSet::add_sun_views(const SunLight& sun, const surface::SurfaceSet& surfaces,
                             const Bounds& media, int map_size)
{
    const glm::dvec3 travel = -glm::normalize(sun.direction_to_light);
    const auto [right, up] = basis(-travel);
    // Bounds in the light's own axes; z grows with the light's travel.
    glm::dmat4 light_from_world(1.0);
    for (int i = 0; i < 3; ++i) {
        light_from_world[i][0] = right[i];
        light_from_world[i][1] = up[i];
        light_from_world[i][2] = travel[i];
    }
    const Bounds outer = surfaces.bounds().transformed(light_from_world);
    Bounds inner = media.transformed(light_from_world);
    if (media.empty())
        inner = outer;
    for (const auto& instance : surfaces.instances())
        if (!media.empty() && instance.bounds.diagonal() <= kLargeSurface * media.diagonal())
            inner.add(instance.bounds.transformed(light_from_world));

    for (const Bounds& covered : {inner, outer}) {
        const glm::dvec2 centre = glm::dvec2(covered.min + covered.max) / 2.0;
        // Two texels of rim stay clear of casters, so a lookup past the edge finds light.
        const glm::dvec2 half =
            glm::dvec2(covered.max - covered.min) / 2.0 * (1 + 6.0 / map_size) + 1e-9;
        View view;
        view.axis = travel;
        view.range = std::max(outer.max.z - outer.min.z, 1e-9) * 1.01;
        const double first = outer.min.z - 0.005 * view.range;
        view.origin = right * centre.x + up * centre.y + travel * first;
        view.bias = 1.5 * 2 * std::max(half.x, half.y) / map_size;
        // Depth is written by the shader, so clip z is 0 all along.
        glm::dmat4 clip_from_light(0.0);
        clip_from_light[0][0] = 1 / half.x;
        clip_from_light[1][1] = 1 / half.y;
        clip_from_light[3] = glm::dvec4(-centre.x / half.x, -centre.y / half.y, 0, 1);
        view.clip_from_world = clip_from_light * light_from_world;
        views_.push_back(view);
    }
}

void LightSet::add_point_views(glm::dvec3 position, double range, int map_size)
{
    constexpr std::array<glm::dvec3, 6> kFaces{glm::dvec3(1, 0, 0), glm::dvec3(-1, 0, 0),
                                               glm::dvec3(0, 1, 0), glm::dvec3(0, -1, 0),
                                               glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1)};
    // A rim of two texels over the right angle, so filtering at a face's edge stays within it.
    const double tangent = 1 + 4.0 / map_size;
    for (const glm::dvec3& face : kFaces) {
        View view;
        view.origin = position;
        view.range = range;
        view.bias = 1.5 * 2 * tangent / map_size;
        view.clip_from_world = glm::perspective(2 * std::atan(tangent), 1.0, range * 1e-6, range) *
                               view_matrix(position, face);
        views_.push_back(view);
    }
}

void LightSet::add_spot_view(const SpotLight& spot, double range, int map_size)
{
    View view;
    view.origin = spot.position;
    view.range = range;
    const double half = std::min(glm::radians(spot.cone_deg) / 2, glm::radians(89.0));
    const double tangent = std::tan(half) * (1 + 4.0 / map_size);
    view.bias = 1.5 * 2 * tangent / map_size;
    view.clip_from_world = glm::perspective(2 * std::atan(tangent), 1.0, range * 1e-6, range) *
                           view_matrix(spot.position, glm::normalize(spot.direction));
    views_.push_back(view);
}

void LightSet::clear()
{
    lights_.clear();
    first_view_.clear();
    views_.clear();
    suns_ = points_ = spots_ = 0;
    shadow_map_ = {};
}

void LightSet::set(const Scene& scene, const surface::SurfaceSet& surfaces, const Bounds& media,
                   int map_size)
{
    clear();
    set_world(scene.world);
    map_size = std::min(map_size, device_.capabilities().max_texture_2d);
    for (const Light& light : scene.lights)
        if (intensity_of(light) != glm::vec3(0.0f))
            lights_.push_back(light);
    std::stable_sort(lights_.begin(), lights_.end(),
                     [](const Light& a, const Light& b) { return a.index() < b.index(); });
    const auto count = [&](std::size_t kind) {
        return static_cast<int>(std::count_if(lights_.begin(), lights_.end(),
                                              [=](const Light& l) { return l.index() == kind; }));
    };
    suns_ = count(0);
    points_ = count(1);
    spots_ = count(2);
    if (lights_.size() > MAX_LIGHTS)
        throw Error(
            fmt::format("the scene has {} lights, and {} is the most at once; leave some out",
                        lights_.size(), MAX_LIGHTS));
    if (surfaces.empty() || lights_.empty())
        return;
    for (const Light& light : lights_) {
        first_view_.push_back(static_cast<int>(views_.size()));
        if (const auto* sun = std::get_if<SunLight>(&light))
            add_sun_views(*sun, surfaces, media, map_size);
        else if (const auto* point = std::get_if<PointLight>(&light))
            add_point_views(point->position, 1.01 * farthest(point->position, surfaces.bounds()),
                            map_size);
        else if (const auto* spot = std::get_if<SpotLight>(&light))
            add_spot_view(*spot, 1.01 * farthest(spot->position, surfaces.bounds()), map_size);
    }
    draw_shadow_map(surfaces, map_size);
}

void LightSet::draw_shadow_map(const surface::SurfaceSet& surfaces, int map_size)
{
    const int size = map_size;
    const auto layers = static_cast<int>(views_.size());
    shadow_map_ = gl::Texture::make_2d_array(device_, "shadow map", {size, size, layers},
                                             GL_DEPTH_COMPONENT32F, gl::Filter::depth_compare);
    if (!framebuffer_)
        framebuffer_ = {device_, "shadow map"};
    device_->UseProgram(programs_.get({"pass/surface.vert", "light/shadow_map.frag"}, {}).id());
    device_->BindBufferBase(GL_UNIFORM_BUFFER, DRAW_BLOCK, draw_block_.id());
    device_->Enable(GL_DEPTH_TEST);
    device_->DepthMask(GL_TRUE);
    device_->DepthFunc(GL_LESS);
    for (int layer = 0; layer < layers; ++layer) {
        const View& view = views_[static_cast<std::size_t>(layer)];
        framebuffer_.attach_depth_layer(shadow_map_.view(), layer);
        framebuffer_.bind({size, size});
        const GLfloat clear = 1.0f;
        device_->ClearNamedFramebufferfv(framebuffer_.id(), GL_DEPTH, 0, &clear);
        for (const auto& instance : surfaces.instances()) {
            shared::DrawParams params{};
            params.clip_from_object = glm::mat4(view.clip_from_world * instance.world_from_object);
            params.world_from_object = glm::mat4(glm::translate(glm::dmat4(1.0), -view.origin) *
                                                 instance.world_from_object);
            params.shadow_origin = glm::vec4(0, 0, 0, 1.0 / view.range);
            params.shadow_axis = glm::vec4(glm::vec3(view.axis), static_cast<float>(view.bias));
            draw_block_.write(params);
            // The far side of a closed surface throws the same shadow as its near side, and leaves
            // the lit near side free of false shadow.
            if (instance.closed) {
                device_->Enable(GL_CULL_FACE);
                device_->CullFace(GL_FRONT);
            } else {
                device_->Disable(GL_CULL_FACE);
            }
            surfaces.draw(instance);
        }
    }
    device_->Disable(GL_CULL_FACE);
    device_->Disable(GL_DEPTH_TEST);
    device_->DepthMask(GL_FALSE);
}

gl::Defines LightSet::defines() const
{
    gl::Defines defines{{"SUN_COUNT", fmt::format("{}", suns_)},
                        {"POINT_COUNT", fmt::format("{}", points_)},
                        {"SPOT_COUNT", fmt::format("{}", spots_)}};
    if (!views_.empty())
        defines.emplace_back("SURFACE_SHADOWS", "");
    return defines;
}

void LightSet::bind(glm::dvec3 eye)
{
    shared::LightsParams params{};
    params.world_radiance = glm::vec4(world_radiance_, 0.0f);
    for (std::size_t i = 0; i < lights_.size(); ++i) {
        shared::LightParams& out = params.lights[i];
        out.intensity = glm::vec4(intensity_of(lights_[i]), 0.0f);
        glm::dvec3 position(0);
        if (const auto* sun = std::get_if<SunLight>(&lights_[i])) {
            position = glm::normalize(sun->direction_to_light);
        } else if (const auto* point = std::get_if<PointLight>(&lights_[i])) {
            position = point->position - eye;
        } else if (const auto* spot = std::get_if<SpotLight>(&lights_[i])) {
            position = spot->position - eye;
            const double edge = std::cos(glm::radians(spot->cone_deg) / 2);
            out.axis =
                glm::vec4(glm::vec3(glm::normalize(spot->direction)), static_cast<float>(edge));
            // Cycles' cone: full from edge + (1 - edge) * blend inwards. 0 would divide by 0.
            out.edge.x = static_cast<float>(1 / std::max((1 - edge) * spot->blend, 1e-6));
        }
        out.position = glm::vec4(glm::vec3(position),
                                 first_view_.empty() ? 0.0f : static_cast<float>(first_view_[i]));
    }
    const glm::dmat4 world_from_eye = glm::translate(glm::dmat4(1.0), eye);
    for (std::size_t v = 0; v < views_.size(); ++v) {
        const View& view = views_[v];
        shared::ShadowView& out = params.views[v];
        out.clip_from_world = glm::mat4(view.clip_from_world * world_from_eye);
        out.origin = glm::vec4(glm::vec3(view.origin - eye), static_cast<float>(1 / view.range));
        out.axis = glm::vec4(glm::vec3(view.axis), static_cast<float>(view.bias));
    }
    block_.write(params);
    device_->BindBufferBase(GL_UNIFORM_BUFFER, LIGHTS_BLOCK, block_.id());
    if (shadow_map_)
        device_->BindTextureUnit(SHADOW_MAP_UNIT, shadow_map_.id());
}

}  // namespace fumarole::light
