#include "light/light_set.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "light/light_source.h"
#include "light/world_light.h"
#include "light_fields.h"
#include <fumarole/errors.h>
#include <fumarole/settings.h>

namespace fumarole::light {

namespace {

static_assert(MAX_SHADOW_VIEWS >= 6 * MAX_LIGHTS, "a point light takes six views");

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
    irradiance_ = upload("irradiance", irradiance_map(*world.environment));
    environment_ = upload("environment", *world.environment);
}

/// A point's six views are then as large together as the two of a sun, and what samples along a ray
/// look up all over them stays in a cache. In media without detail shafts of shadow are all there
/// is to see, and they spread over what a sun's view covers; through gaps they have edges all over
/// the picture (a hall under slots errs by a relMSE of 1.07e-3 with 2048 texels, 0.95e-3 with
/// 3072). Lights of many points have as many views, each of which matters the less: they share what
/// 16 point lights would take.
int LightSet::automatic_map_size(bool detailed, bool through_gaps) const
{
    if (points_.size() > lights_.size())
        return std::min(512, static_cast<int>(512 * std::sqrt(16.0 / double(points_.size()))));
    if (suns_ == 0)
        return 512;
    return detailed ? 1024 : through_gaps ? 3072 : 2048;
}

void LightSet::clear()
{
    clear_lights();
    filters_.clear();
    painter_.release();
    throws_shadows_ = false;
}

void LightSet::clear_lights()
{
    lights_.clear();
    points_.clear();
    spans_.clear();
    radii_.clear();
    views_.clear();
    caster_bounds_.clear();
    suns_ = flames_ = 0;
    shaded_media_ = false;
    sun_readbacks_.clear();
    shadow_map_ = {};
}

void LightSet::set_filters(const Scene& scene, std::span<const Caster> casters, int map_size,
                           int of_grids)
{
    // A view covers transparents alone.
    constexpr int kMost = 1024;
    if (map_size == kAutomatic)
        map_size = std::min(kMost, automatic_map_size(true, false));
    filters_.set(lights_, casters, casters_of(scene.transparents),
                 std::min(map_size, device_.capabilities().max_texture_2d), of_grids);
}

glm::ivec2 LightSet::flame_points() const
{
    // Suns and points come first, with a point each.
    const auto beyond = std::find_if(lights_.begin(), lights_.end(), [](const Light& light) {
        return !std::holds_alternative<SunLight>(light) &&
               !std::holds_alternative<PointLight>(light);
    });
    const auto end = static_cast<int>(beyond - lights_.begin());
    return {end - flames_, end};
}

void LightSet::set(const Scene& scene, const surface::SurfaceSet& surfaces, const Bounds& media,
                   int map_size, bool detailed, bool through_gaps,
                   std::span<const FlameLight> flames)
{
    ShadowMap old{std::move(views_), std::move(shadow_map_), std::move(sun_readbacks_)};
    clear_lights();
    set_world(scene.world);
    std::vector<std::pair<Light, double>> all;
    for (const Light& light : scene.lights)
        if (power_of(light) != glm::vec3(0.0f))
            all.emplace_back(light, 0);
    for (const FlameLight& flame : flames)
        all.emplace_back(flame.light, flame.radius);
    flames_ = static_cast<int>(flames.size());
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
        return a.first.index() < b.first.index();
    });
    for (const auto& [light, radius] : all) {
        lights_.push_back(light);
        radii_.push_back(radius);
    }
    suns_ = static_cast<int>(std::count_if(
        lights_.begin(), lights_.end(), [](const Light& light) { return position_of(light).far; }));
    if (lights_.size() > MAX_LIGHTS)
        throw Error(
            fmt::format("the scene has {} lights, and {} is the most at once; leave some out",
                        lights_.size(), MAX_LIGHTS));
    for (const Light& light : lights_) {
        const std::vector<LightPosition> points = points_of(light);
        spans_.push_back({.first_point = points_.size(), .points = points.size()});
        points_.insert(points_.end(), points.begin(), points.end());
    }
    if (points_.size() > MAX_LIGHT_POINTS)
        throw Error(fmt::format("the scene's {} lights are {} points, and {} is the most at once; "
                                "leave some out",
                                lights_.size(), points_.size(), MAX_LIGHT_POINTS));
    const Bounds seen = outside_of_boxes(media, surfaces.instances());
    for (const LightPosition& point : points_)
        for (const auto& instance : surfaces.instances())
            shaded_media_ |= !seen.empty() && can_shade(point, instance.bounds, seen);
    // A ground alone throws no shadow on what is seen. Of surfaces that did throw one the map
    // stays: if it came and went as things move, shaders would be compiled amid frames.
    const bool did = throws_shadows_ && casters_.size() == scene.surfaces.size();
    throws_shadows_ = !surfaces.empty() && !lights_.empty() &&
                      (did || shaded_media_ || can_shade_surfaces(points_, surfaces.instances()));
    if (!throws_shadows_) {
        painter_.release();
        return;
    }
    if (map_size == kAutomatic)
        map_size = automatic_map_size(detailed, through_gaps);
    if (const int most = device_.capabilities().max_texture_2d; map_size > most) {
        device_.log(LogLevel::warning,
                    fmt::format("SceneSettings::shadow_map: {} texels are more than this GL's "
                                "textures hold along an edge; {} are taken",
                                map_size, most));
        map_size = most;
    }
    for (const auto& instance : surfaces.instances())
        caster_bounds_.push_back(instance.bounds);
    std::size_t in_block = 0;
    for (std::size_t i = 0; i < lights_.size(); ++i) {
        const LightViews views = views_of(lights_[i], {surfaces, media, map_size});
        spans_[i].first_layer = views_.size();
        spans_[i].first_view = in_block;
        spans_[i].views = static_cast<std::size_t>(views.in_block);
        in_block += spans_[i].views;
        views_.insert(views_.end(), views.layers.begin(), views.layers.end());
    }
    std::vector<Surface> casters = scene.surfaces;
    for (Surface& caster : casters)  // what it looks like throws no shadow
        std::visit(
            [](auto& surface) {
                surface.albedo = surface.emission = glm::vec3(0);
                surface.gloss.reset();
            },
            caster);
    if (old.texture && (old.texture.size().x != map_size || casters != casters_))
        old = {};
    casters_ = std::move(casters);
    draw_shadow_map(std::move(old), surfaces, map_size);
}

void LightSet::draw_shadow_map(ShadowMap old, const surface::SurfaceSet& surfaces, int map_size)
{
    if (!old.texture)
        old.views.clear();
    const auto layer_of = [](const std::vector<View>& views, std::size_t wanted, const View& view) {
        if (wanted < views.size() && views[wanted] == view)
            return std::optional(wanted);
        const auto at = std::find(views.begin(), views.end(), view);
        return at == views.end() ? std::nullopt
                                 : std::optional(static_cast<std::size_t>(at - views.begin()));
    };
    std::vector<std::optional<std::size_t>> from;
    bool in_place = old.views.size() == views_.size();
    for (std::size_t i = 0; i < views_.size(); ++i) {
        from.push_back(layer_of(old.views, i, views_[i]));
        in_place &= !from[i] || *from[i] == i;
    }
    shadow_map_ = in_place ? std::move(old.texture) : painter_.make_map(views_.size(), map_size);
    for (std::size_t i = 0; i < views_.size(); ++i) {
        if (!from[i]) {
            painter_.draw(shadow_map_, i, views_[i], surfaces);
            ++views_drawn_;
        } else if (!in_place) {
            device_->CopyImageSubData(old.texture.id(), GL_TEXTURE_2D_ARRAY, 0, 0, 0,
                                      static_cast<GLint>(*from[i]), shadow_map_.id(),
                                      GL_TEXTURE_2D_ARRAY, 0, 0, 0, static_cast<GLint>(i), map_size,
                                      map_size, 1);
        }
    }
    sun_readbacks_.resize(static_cast<std::size_t>(suns_));
    for (int i = 0; i < suns_; ++i)
        if (const auto layer = from[sun_view(i)])
            for (SunReadback& readback : old.readbacks)
                if (readback.layer == *layer && (readback.depths || readback.shadow)) {
                    SunReadback& kept = sun_readbacks_[static_cast<std::size_t>(i)];
                    kept = std::move(readback);
                    kept.layer = sun_view(i);
                    break;
                }
}

LightSet::SunReadback& LightSet::sun_readback(int i) const
{
    SunReadback& sun = sun_readbacks_[static_cast<std::size_t>(i)];
    if (!sun.depths && !sun.shadow) {
        sun.layer = sun_view(i);
        sun.depths = {device_, shadow_map_.view(), static_cast<int>(sun.layer), GL_DEPTH_COMPONENT};
    }
    return sun;
}

const SunShadow* LightSet::sun_shadow(int i) const
{
    SunReadback& sun = sun_readback(i);
    if (!sun.shadow && sun.depths.ready()) {
        sun.shadow = {views_[sun_view(i)], DepthPyramid(sun.depths.texels(), shadow_map_.size().x)};
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
    if (flames_ > 0)
        defines.emplace_back("kFlames", "");
    defines += filters_.defines();
    return defines;
}

bool LightSet::has_edges() const
{
    return std::any_of(lights_.begin(), lights_.end(),
                       [](const Light& light) { return std::isfinite(edge_angle_of(light)); });
}

double LightSet::edge_width(const Bounds& media) const
{
    double least = std::numeric_limits<double>::infinity();
    for (const Light& light : lights_) {
        const double angle = edge_angle_of(light);
        if (!std::isfinite(angle))
            continue;
        const glm::dvec3 at = position_of(light).at;
        least = std::min(least, angle * glm::length(at - glm::clamp(at, media.min, media.max)));
    }
    return least;
}

bool LightSet::has_area_in(const Bounds& media) const
{
    return std::any_of(lights_.begin(), lights_.end(), [&](const Light& light) {
        if (!std::holds_alternative<RectLight>(light) && !std::holds_alternative<DiskLight>(light))
            return false;
        return std::ranges::any_of(points_of(light), [&](const LightPosition& point) {
            return glm::clamp(point.at, media.min, media.max) == point.at;
        });
    });
}

void LightSet::bind(glm::dvec3 eye)
{
    shared::LightsParams params{};
    params.world_radiance = glm::vec4(world_radiance_, 0.0f);
    for (std::size_t i = 0; i < lights_.size(); ++i) {
        const Span& span = spans_[i];
        const std::span points(&params.lights[span.first_point], span.points);
        for (std::size_t k = 0; k < span.points; ++k) {
            const LightPosition& place = points_[span.first_point + k];
            points[k].position = glm::vec3(place.far ? place.at : place.at - eye);
            points[k].intensity = power_of(lights_[i]);
            points[k].first_view = static_cast<float>(span.first_view);
        }
        if (radii_[i] > 0)
            points.front().own[0] = glm::vec4(static_cast<float>(radii_[i]), 0, 0, 0);
        write_own(lights_[i], {eye, shadow_map_.size().x, static_cast<int>(span.first_layer)},
                  points);
        for (std::size_t v = 0; v < span.views; ++v)
            params.views[span.first_view + v] = to_shared(views_[span.first_layer + v], eye);
    }
    block_.write(params);
    device_->BindBufferBase(GL_UNIFORM_BUFFER, LIGHTS_BLOCK, block_.id());
    shadow_map_.bind(SHADOW_MAP_UNIT);
    filters_.bind(eye);
}

}  // namespace fumarole::light
