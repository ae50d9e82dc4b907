#include "light/light_filters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "light/light_source.h"
#include "overloaded.h"
#include "shared/bindings.h"
#include <fumarole/errors.h>

namespace fumarole::light {

namespace {

/// Of a view: a place behind the last but one of them, and before others, has those others' filter
/// too.
constexpr int kMostLayers = 4;
/// Of 16 bytes, in all views.
constexpr int kMostTexels = 8 << 20;
constexpr int kLeastSize = 64;

/// Of a view: what has an edge in common is not behind another.
constexpr double kTouch = 1e-6;

/// What of a view something may cover, -1..1 each way.
struct Seen {
    glm::dvec2 low{-1}, high{1};
};

Seen seen_in(const View& view, const Bounds& bounds)
{
    Seen seen{glm::dvec2(1e30), glm::dvec2(-1e30)};
    int before = 0;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec4 clip = view.clip_from_world * glm::dvec4(bounds.corner(i), 1.0);
        if (!(clip.w > 0))
            continue;
        ++before;
        seen.low = glm::min(seen.low, glm::dvec2(clip) / clip.w + kTouch);
        seen.high = glm::max(seen.high, glm::dvec2(clip) / clip.w - kTouch);
    }
    return before == 0 || before == 8 ? seen : Seen();  // it may be anywhere
}

/// A quad's corners on a view, if all are before the light; none of a mesh, whose outline is not
/// known.
std::vector<glm::dvec2> corners_on(const View& view, const Caster& caster)
{
    std::vector<glm::dvec2> corners;
    for (const glm::dvec2 at : {glm::dvec2(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
        const glm::dvec4 clip =
            view.clip_from_world * caster.world_from_object * glm::dvec4(at, 0, 1);
        if (caster.overlaps_itself || !(clip.w > 0))
            return {};
        corners.push_back(glm::dvec2(clip) / clip.w);
    }
    return corners;
}

/// Whether a line along an edge of `a` has `b` on its other side: two convex ones are apart where
/// one of either has.
bool is_apart_by_an_edge(const std::vector<glm::dvec2>& a, const std::vector<glm::dvec2>& b)
{
    for (std::size_t i = 0; i < a.size(); ++i) {
        const glm::dvec2 along = a[(i + 1) % a.size()] - a[i], across(along.y, -along.x);
        const double length = glm::length(across);
        glm::dvec2 of_a(1e30, -1e30), of_b(1e30, -1e30);
        const auto spread = [&](glm::dvec2& over, const std::vector<glm::dvec2>& corners) {
            for (const glm::dvec2& corner : corners) {
                const double away = glm::dot(corner - a[i], across) / length;
                over = {std::min(over.x, away), std::max(over.y, away)};
            }
        };
        spread(of_a, a);
        spread(of_b, b);
        if (of_a.y < of_b.x + kTouch || of_b.y < of_a.x + kTouch)
            return true;
    }
    return false;
}

/// How many transparents may lie one behind the other in a view: no fewer than do.
int most_behind_another(const View& view, std::span<const Caster> casters)
{
    std::vector<Seen> all;
    std::vector<std::vector<glm::dvec2>> corners;
    for (const Caster& caster : casters) {
        all.push_back(seen_in(view, caster.bounds()));
        corners.push_back(corners_on(view, caster));
    }
    const auto are_apart = [&](std::size_t i, std::size_t k) {
        return i != k && !corners[i].empty() && !corners[k].empty() &&
               (is_apart_by_an_edge(corners[i], corners[k]) ||
                is_apart_by_an_edge(corners[k], corners[i]));
    };
    int most = 1;
    for (std::size_t i = 0; i < all.size(); ++i) {
        int over = 0;
        for (std::size_t k = 0; k < all.size(); ++k)
            if (glm::all(glm::lessThan(all[i].low, all[k].high)) &&
                glm::all(glm::lessThan(all[k].low, all[i].high)) && !are_apart(i, k))
                over += casters[k].overlaps_itself ? 2 : 1;
        most = std::max(most, over);
    }
    return most;
}

/// Metres from a place to the farthest corner of what casts.
double range_over(glm::dvec3 from, const Bounds& bounds)
{
    double far = 0;
    for (int i = 0; i < 8; ++i)
        far = std::max(far, glm::length(bounds.corner(i) - from));
    return 1.01 * far;
}

}  // namespace

std::vector<Transparent> casters_of(const std::vector<Transparent>& transparents)
{
    std::vector<Transparent> casters;
    for (const Transparent& transparent : transparents)
        if (look_of(transparent).casts)
            casters.push_back(transparent);
    for (Transparent& caster : casters)  // that only the eye sees
        look_of(caster).depth_fade = 0;
    return casters;
}

void LightFilters::clear()
{
    map_ = {};
    views_.clear();
    points_.clear();
    filtered_suns_.clear();
    kept_.clear();
    bounds_ = {};
    layers_ = 0;
}

void LightFilters::add_views(std::span<const View> views)
{
    points_.push_back(views_.size());
    views_.insert(views_.end(), views.begin(), views.end());
}

void LightFilters::add_sun(const SunLight& sun, std::span<const Caster> casters, int map_size)
{
    const LightAxes axes(sun.direction_to_light);
    Bounds seen = bounds_.transformed(axes.light_from_world);
    // One that faces the sun has no depth, which would have none to be told by.
    constexpr double kDepth = 0.01;  // of its size
    const double margin = kDepth * glm::length(seen.max - seen.min);
    seen.min.z -= margin;
    seen.max.z += margin;
    const View view = parallel_view(axes, seen, seen, map_size);
    add_views({&view, 1});
    for (const Caster& caster : casters) {
        const Bounds its = caster.bounds().transformed(axes.light_from_world);
        const Seen on_view = seen_in(view, caster.bounds());
        filtered_suns_.push_back({view, on_view.low * 0.5 + 0.5, on_view.high * 0.5 + 0.5,
                                  (its.min.z - glm::dot(view.origin, view.axis)) / view.range});
    }
}

void LightFilters::add_light(const Light& light, std::span<const Caster> casters, int map_size)
{
    const auto add_points = [&](const auto&) {
        for (const LightPosition& point : points_of(light))
            add_views(point_views(point.at, range_over(point.at, bounds_), map_size));
    };
    std::visit(Overloaded{[&](const SunLight& sun) { add_sun(sun, casters, map_size); },
                          [&](const SpotLight& spot) {
                              const View view =
                                  spot_view(spot, range_over(spot.position, bounds_), map_size);
                              add_views({&view, 1});
                          },
                          [&](const PointLight& point) { add_points(point); },
                          [&](const RectLight& area) { add_points(area); },
                          [&](const DiskLight& area) { add_points(area); }},
               light);
}

void LightFilters::set(std::span<const Light> lights, std::span<const Caster> casters,
                       std::vector<Transparent> kept, int map_size, int of_grids)
{
    if (casters.empty() || lights.empty()) {
        clear();
        return;
    }
    if (MOST_SAMPLED + of_grids >= device_.capabilities().max_texture_units)
        throw Error(fmt::format("Scene::transparents: those that cast need a texture unit, and the "
                                "scene's grids have taken all {} of this GL; leave 'casts' out, "
                                "or a medium",
                                device_.capabilities().max_texture_units));
    const std::vector<View> old_views = std::move(views_);
    gl::Texture old_map = std::move(map_);
    const std::vector<Transparent> old_kept = std::move(kept_);
    clear();
    kept_ = std::move(kept);
    for (const Caster& caster : casters)
        bounds_.add(caster.bounds());
    const auto plan = [&] {
        views_.clear();
        points_.clear();
        filtered_suns_.clear();
        layers_ = 1;
        for (const Light& light : lights)
            add_light(light, casters, map_size);
        for (const View& view : views_)
            layers_ = std::max(layers_, most_behind_another(view, casters));
        layers_ = std::min(layers_, kMostLayers);
        return views() * layers_;
    };
    // A light that has an area has 96 views.
    while (plan() * map_size > kMostTexels / map_size && map_size > kLeastSize)
        map_size /= 2;
    if (old_map && old_map.size().x == map_size && views_ == old_views && kept_ == old_kept) {
        map_ = std::move(old_map);
        return;
    }
    draw(casters, map_size);
    views_drawn_ += views();
}

void LightFilters::draw(std::span<const Caster> casters, int map_size)
{
    const gl::Device& gl = device_;
    const glm::ivec2 size(map_size);
    map_ = gl::Texture::make_2d_array(gl, "light filters", {size, views() * layers_}, GL_RGBA32F,
                                      gl::Filter::nearest);
    gl::Texture depth;
    if (layers_ > 1)
        depth = gl::Texture::make_2d(gl, "light filters' depth", size, GL_DEPTH_COMPONENT32F,
                                     gl::Filter::nearest);
    if (!framebuffer_)
        framebuffer_ = {gl, "light filters"};
    gl->BindBufferBase(GL_UNIFORM_BUFFER, DRAW_BLOCK, draw_block_.id());
    map_.bind(LIGHT_FILTERS_UNIT);
    gl->DepthFunc(GL_LESS);
    // Of the last layers.
    gl->BlendEquationSeparatei(0, GL_FUNC_ADD, GL_MIN);
    gl->BlendFuncSeparatei(0, GL_ZERO, GL_SRC_COLOR, GL_ONE, GL_ONE);
    for (int view = 0; view < views(); ++view)
        for (int k = 0; k < layers_; ++k) {
            const int layer = view * layers_ + k;
            const bool last = k + 1 == layers_;
            framebuffer_.attach_color_layer(map_.view(), layer);
            framebuffer_.attach_depth(last ? gl::TextureView{} : depth.view());
            framebuffer_.bind(size);
            constexpr std::array<GLfloat, 4> kClear{1, 1, 1, 2};  // behind all there is
            constexpr GLfloat kFar = 1;
            gl->ClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 0, kClear.data());
            if (last) {
                gl->Enablei(GL_BLEND, 0);
            } else {
                gl->Enable(GL_DEPTH_TEST);
                gl->DepthMask(GL_TRUE);
                gl->ClearNamedFramebufferfv(framebuffer_.id(), GL_DEPTH, 0, &kFar);
            }
            // A layer is drawn by what is in the one before it.
            gl->TextureBarrier();
            draw_casters(casters, views_[static_cast<std::size_t>(view)],
                         k > 0 ? gl::Defines{{"kBehind", ""}} : gl::Defines{}, layer - 1);
            gl->Disablei(GL_BLEND, 0);
            gl->Disable(GL_DEPTH_TEST);
            gl->DepthMask(GL_FALSE);
        }
    framebuffer_.attach_depth({});
    framebuffer_.detach_color();
}

void LightFilters::draw_casters(std::span<const Caster> casters, const View& view,
                                const gl::Defines& defines, int layer_before)
{
    const glm::dmat4 light_from_world = glm::translate(glm::dmat4(1.0), -view.origin);
    for (const Caster& caster : casters) {
        shared::LightFilterDrawParams params{};
        params.clip_from_object = glm::mat4(view.clip_from_world * caster.world_from_object);
        params.light_from_object = glm::mat4(light_from_world * caster.world_from_object);
        params.depth = to_shared(view, view.origin).depth;
        params.source = caster.source;
        params.factor = caster.factor;
        params.is_filter = caster.is_filter ? 1 : 0;
        params.layer_before = layer_before;
        draw_block_.write(params);
        gl::Defines own = defines;
        if (caster.image) {
            own.emplace_back("kImage", "");
            gl::bind_texture(device_, TRANSPARENT_IMAGE_UNIT, caster.image);
        }
        device_->UseProgram(programs_.get({"light/filter.vert", "light/filter.frag"}, own).id());
        caster.mesh->draw(device_);
    }
}

gl::Defines LightFilters::defines() const
{
    if (!any())
        return {};
    return {{"LIGHT_FILTERS", ""}, {"kFilterLayers", fmt::format("{}", layers_)}};
}

void LightFilters::bind(glm::dvec3 eye) const
{
    if (!any())
        return;
    shared::LightFiltersParams params{};
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const std::size_t first = points_[i];
        const shared::ShadowView view = to_shared(views_[first], eye);
        shared::LightFilterParams& own = params.points[i];
        own.clip_from_world = view.clip_from_world;
        own.depth = view.depth;
        own.first_layer = static_cast<float>(first * static_cast<std::size_t>(layers_));
        own.cube_view_scale = 0.5f / static_cast<float>(point_view_tangent(map_.size().x));
    }
    block_.write(params);
    device_->BindBufferBase(GL_UNIFORM_BUFFER, LIGHT_FILTERS_BLOCK, block_.id());
    map_.bind(LIGHT_FILTERS_UNIT);
}

}  // namespace fumarole::light
