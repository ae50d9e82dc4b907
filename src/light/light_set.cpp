#include "light/light_set.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "light/light_source.h"
#include "light/world_light.h"
#include "light_fields.h"
#include <fumarole/errors.h>
#include <fumarole/settings.h>

namespace fumarole::light {

namespace {

static_assert(MAX_SHADOW_VIEWS >= 6 * MAX_LIGHTS, "a point light takes six views");

/// Distance from a point to the farthest corner of a box.
double farthest(glm::dvec3 p, const Bounds& bounds)
{
    double far = 0;
    for (int i = 0; i < 8 && !bounds.empty(); ++i)
        far = std::max(far, glm::length(bounds.corner(i) - p));
    return far;
}

/// A point's six views are then as large together as the two of a sun, and what samples along a ray
/// look up all over them stays in a cache. In media without detail shafts of shadow are all there
/// is to see, and they spread over what a sun's view covers.
int automatic_map_size(int suns, bool detailed)
{
    if (suns == 0)
        return 512;
    return detailed ? 1024 : 2048;
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
    const LightAxes axes(sun.direction_to_light);
    const Bounds outer = surfaces.bounds().transformed(axes.light_from_world);
    Bounds inner = media.transformed(axes.light_from_world);
    if (media.empty())
        inner = outer;
    for (const auto& instance : surfaces.instances())
        if (is_detail(instance, media))  // others are in the outer view alone
            inner.add(instance.bounds.transformed(axes.light_from_world));
    for (const Bounds& covered : {inner, outer})
        views_.push_back(parallel_view(axes, covered, outer, map_size));
}

void LightSet::clear()
{
    lights_.clear();
    first_view_.clear();
    views_.clear();
    suns_ = 0;
    shaded_media_ = false;
    sun_readbacks_.clear();
    shadow_map_ = {};
}

void LightSet::set(const Scene& scene, const surface::SurfaceSet& surfaces, const Bounds& media,
                   int map_size, bool detailed)
{
    clear();
    set_world(scene.world);
    for (const Light& light : scene.lights)
        if (power_of(light) != glm::vec3(0.0f))
            lights_.push_back(light);
    std::stable_sort(lights_.begin(), lights_.end(),
                     [](const Light& a, const Light& b) { return a.index() < b.index(); });
    suns_ = static_cast<int>(std::count_if(
        lights_.begin(), lights_.end(), [](const Light& light) { return position_of(light).far; }));
    if (lights_.size() > MAX_LIGHTS)
        throw Error(
            fmt::format("the scene has {} lights, and {} is the most at once; leave some out",
                        lights_.size(), MAX_LIGHTS));
    if (surfaces.empty() || lights_.empty())
        return;
    if (map_size == kAutomatic)
        map_size = automatic_map_size(suns_, detailed);
    if (const int most = device_.capabilities().max_texture_2d; map_size > most) {
        device_.log(LogLevel::warning,
                    fmt::format("SceneSettings::shadow_map: {} texels are more than this GL's "
                                "textures hold along an edge; {} are taken",
                                map_size, most));
        map_size = most;
    }
    for (const Light& light : lights_) {
        for (const auto& instance : surfaces.instances())
            shaded_media_ |= !media.empty() && can_shade(light, instance.bounds, media);
        first_view_.push_back(static_cast<int>(views_.size()));
        const auto range_from = [&](glm::dvec3 p) { return 1.01 * farthest(p, surfaces.bounds()); };
        std::visit(
            Overloaded{[&](const SunLight& sun) { add_sun_views(sun, surfaces, media, map_size); },
                       [&](const PointLight& point) {
                           const glm::dvec3 p = point.position;
                           for (const View& view : point_views(p, range_from(p), map_size))
                               views_.push_back(view);
                       },
                       [&](const SpotLight& spot) {
                           views_.push_back(spot_view(spot, range_from(spot.position), map_size));
                       }},
            light);
    }
    shadow_map_ = painter_.draw(views_, surfaces, map_size);
}

LightSet::SunReadback& LightSet::sun_readback(int i) const
{
    sun_readbacks_.resize(static_cast<std::size_t>(suns_));
    SunReadback& sun = sun_readbacks_[static_cast<std::size_t>(i)];
    if (!sun.depths && !sun.shadow)
        sun.depths = {device_, shadow_map_.view(), first_view_[static_cast<std::size_t>(i)]};
    return sun;
}

const SunShadow* LightSet::sun_shadow(int i) const
{
    SunReadback& sun = sun_readback(i);
    if (!sun.shadow && sun.depths.ready()) {
        const auto view = static_cast<std::size_t>(first_view_[static_cast<std::size_t>(i)]);
        sun.shadow = {views_[view], DepthPyramid(sun.depths.texels(), shadow_map_.size().x)};
        sun.depths = {};
    }
    return sun.shadow ? &*sun.shadow : nullptr;
}

void LightSet::wait_for_sun_shadows() const
{
    for (int i = 0; i < suns_ && !views_.empty(); ++i)
        while (sun_shadow(i) == nullptr)
            sun_readback(i).depths.wait();
}

gl::Defines LightSet::defines() const
{
    gl::Defines defines = write_lights(lights_);
    if (!views_.empty())
        defines.emplace_back("kSurfaceShadows", "");
    return defines;
}

bool LightSet::has_edges() const
{
    return std::any_of(lights_.begin(), lights_.end(), [](const Light& light) {
        return std::visit(Overloaded{[](const SunLight&) { return false; },
                                     [](const PointLight&) { return false; },
                                     [](const SpotLight&) { return true; }},
                          light);
    });
}

void LightSet::bind(glm::dvec3 eye)
{
    shared::LightsParams params{};
    params.world_radiance = glm::vec4(world_radiance_, 0.0f);
    for (std::size_t i = 0; i < lights_.size(); ++i) {
        shared::LightParams& out = params.lights[i];
        out.intensity = power_of(lights_[i]);
        const LightPosition place = position_of(lights_[i]);
        out.position = glm::vec3(place.far ? place.at : place.at - eye);
        std::visit(
            Overloaded{[](const SunLight&) {},
                       [&](const PointLight&) {
                           out.cube_view_scale =
                               0.5f / static_cast<float>(point_view_tangent(shadow_map_.size().x));
                       },
                       [&](const SpotLight& spot) {
                           const double edge = std::cos(glm::radians(spot.cone_deg) / 2);
                           out.axis = glm::vec3(glm::normalize(spot.direction));
                           out.cos_half_cone = static_cast<float>(edge);
                           // Cycles' cone: full from edge + (1 - edge) * blend inwards. 0
                           // would divide by 0.
                           out.inverse_edge_width =
                               static_cast<float>(1 / std::max((1 - edge) * spot.blend, 1e-6));
                       }},
            lights_[i]);
        out.first_view = first_view_.empty() ? 0.0f : static_cast<float>(first_view_[i]);
    }
    for (std::size_t v = 0; v < views_.size(); ++v)
        params.views[v] = to_shared(views_[v], eye);
    block_.write(params);
    device_->BindBufferBase(GL_UNIFORM_BUFFER, LIGHTS_BLOCK, block_.id());
    shadow_map_.bind(SHADOW_MAP_UNIT);
}

}  // namespace fumarole::light
