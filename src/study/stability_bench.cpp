#include "study/stability_bench.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "gl/texture.h"
#include "halton.h"
#include "study/reference_media.h"

namespace fumarole::study {

namespace {

/// A host's textures and the frame that they are.
struct HostPicture {
    HostPicture(const gl::Device& gl, const Camera& camera, glm::uvec2 resolution)
        : size{resolution}, color{gl::Texture::make_2d(gl, "picture", size, GL_RGBA32F,
                                                       gl::Filter::nearest)},
          depth{gl::Texture::make_2d(gl, "picture depth", size, GL_DEPTH_COMPONENT32F,
                                     gl::Filter::nearest)}
    {
        frame.color = color.view();
        frame.depth = depth.view();
        frame.depth_convention = {.zero_to_one = true, .reversed = true};
        frame.view_from_world = view_from_world(camera);
        frame.clip_from_view = clip_from_view(camera, resolution, glm::dvec2(0));
    }

    [[nodiscard]] Picture read() const
    {
        const std::vector<float> rgba = color.read(4);
        Picture picture{size.x, size.y, {}};
        for (int y = size.y - 1; y >= 0; --y)
            for (int x = 0; x < size.x; ++x)
                for (int c = 0; c < 3; ++c)
                    picture.rgb.push_back(rgba[static_cast<std::size_t>((y * size.x + x) * 4 + c)]);
        return picture;
    }

    glm::ivec2 size;
    gl::Texture color, depth;
    Frame frame;
};

StabilityFigure figure_of(double value, const Picture& actual, const Picture& expected)
{
    return {value, {actual.width, actual.height, actual.rgb, expected.rgb}};
}

/// The largest of a number per value. std::max would pass over a NaN.
template <class Measure>
StabilityFigure largest_of(const Picture& actual, const Picture& expected, const Measure& measure)
{
    double worst = 0;
    for (std::size_t i = 0; i < expected.rgb.size(); ++i) {
        const double value = measure(double(actual.rgb[i]), double(expected.rgb[i]));
        if (!(value <= worst))
            worst = value;
        if (std::isnan(worst))
            break;
    }
    return figure_of(worst, actual, expected);
}

}  // namespace

PixelRay pixel_ray(const Scene& scene, glm::dvec2 at)
{
    const Camera& camera = scene.camera;
    const glm::dvec2 size(scene.resolution);
    const glm::dvec2 ndc(2 * at.x / size.x - 1, 1 - 2 * at.y / size.y);
    const double aspect = size.x / size.y;
    const glm::dvec3 forward = glm::normalize(camera.look_at - camera.position);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, camera.up));
    const glm::dvec3 up = glm::cross(right, forward);
    PixelRay ray;
    if (camera.projection == Camera::Projection::orthographic) {
        const double half = camera.ortho_height / 2;
        ray.origin = camera.position + right * (ndc.x * half * aspect) + up * (ndc.y * half);
        ray.direction = forward;
        return ray;
    }
    const double tangent = std::tan(glm::radians(camera.vfov_deg) / 2);
    const glm::dvec3 direction =
        forward + right * (ndc.x * tangent * aspect) + up * (ndc.y * tangent);
    ray.origin = camera.position;
    ray.direction = glm::normalize(direction);
    ray.length_per_z = glm::length(direction);
    return ray;
}

double Picture::mean() const
{
    double sum = 0;
    for (const float v : rgb)
        sum += double(v);
    return sum / static_cast<double>(rgb.size());
}

glm::vec3 Picture::at(int x, int y) const
{
    const std::size_t i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                               static_cast<std::size_t>(x));
    return {rgb[i], rgb[i + 1], rgb[i + 2]};
}

Picture evaluate(const Scene& scene, const PictureField& field)
{
    const glm::ivec2 size(scene.resolution);
    Picture picture{size.x, size.y, {}};
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const glm::vec3 value(field(pixel_ray(scene, {x + 0.5, y + 0.5})));
            picture.rgb.insert(picture.rgb.end(), {value.r, value.g, value.b});
        }
    return picture;
}

StabilityFigure worst_difference(const Picture& actual, const Picture& expected)
{
    return largest_of(actual, expected, [](double a, double e) { return std::abs(a - e); });
}

StabilityFigure worst_ratio(const Picture& actual, const Picture& expected)
{
    return largest_of(actual, expected, [](double a, double e) {
        return e == 0 ? 0.0 : std::abs(a - e) / std::abs(e);
    });
}

StabilityFigure rms_over_mean(const Picture& actual, const Picture& expected)
{
    double square = 0, mean = 0;
    for (std::size_t i = 0; i < expected.rgb.size(); ++i) {
        square += std::pow(double(actual.rgb[i]) - double(expected.rgb[i]), 2);
        mean += std::abs(double(expected.rgb[i]));
    }
    const auto n = static_cast<double>(expected.rgb.size());
    return figure_of(std::sqrt(square / n) / (mean / n), actual, expected);
}

StabilityFigure mean_ratio(const Picture& actual, const Picture& expected)
{
    return figure_of(std::abs(actual.mean() / expected.mean() - 1), actual, expected);
}

StabilityFigure count_bad(const Still& still)
{
    int bad = 0;
    const auto count = [&](const std::vector<float>& values, float most) {
        for (const float v : values)
            bad += std::isfinite(v) && v >= 0 && v <= most ? 0 : 1;
    };
    constexpr float kMost = std::numeric_limits<float>::max();
    count(still.composite, kMost);
    count(still.scattering, kMost);
    count(still.surface_lit, kMost);
    count(still.transmittance, 1);
    Picture nothing{still.width, still.height, std::vector<float>(still.composite.size(), 0.0f)};
    return figure_of(bad, layer(still, &Still::composite), nothing);
}

StabilityFigure worse(StabilityFigure a, StabilityFigure b)
{
    return std::isnan(a.value) || a.value > b.value ? std::move(a) : std::move(b);
}

double fitted_order(const std::vector<int>& steps, const std::vector<double>& errors)
{
    double x = 0, y = 0, xx = 0, xy = 0;
    const auto n = static_cast<double>(steps.size());
    for (std::size_t i = 0; i < steps.size(); ++i) {
        const double u = std::log(static_cast<double>(steps[i])), v = -std::log(errors[i]);
        x += u;
        y += v;
        xx += u * u;
        xy += u * v;
    }
    return (n * xy - x * y) / (n * xx - x * x);
}

Scene bare_scene(int size)
{
    Scene scene;
    scene.resolution = glm::uvec2(static_cast<unsigned>(size));
    scene.camera.position = {0, 0, 0};
    scene.camera.look_at = {0, -1, 0};
    scene.camera.vfov_deg = 40;
    scene.camera.near = 0.1;
    scene.camera.far = 100;
    return scene;
}

BoxMedium slab(double near_y, double far_y)
{
    BoxMedium box;
    box.min = {-200, -far_y, -200};
    box.max = {200, -near_y, 200};
    return box;
}

double length_in(const Scene& scene, const PixelRay& ray, const BoxMedium& box)
{
    const glm::dvec2 range = box_range(ray, {box.min, box.max});
    return std::max(0.0, range.y - std::max(range.x, scene.camera.near * ray.length_per_z));
}

glm::dvec3 box_transmittance(const Scene& scene, const PixelRay& ray, const BoxMedium& box)
{
    return glm::exp(-glm::dvec3(box.sigma_s + box.sigma_a) * length_in(scene, ray, box));
}

Picture true_transmittance(const Scene& scene)
{
    const ReferenceMedia media(scene, 1e-9);
    return evaluate(scene, [&](const PixelRay& ray) {
        Ray from = ray;
        from.origin = ray.at(scene.camera.near * ray.length_per_z);
        return glm::exp(-media.optical_depth(from, kInfinity));
    });
}

glm::dvec3 sun_in_slab(const Scene& scene, const PixelRay& ray, const BoxMedium& box,
                       const SunLight& sun)
{
    const double length = length_in(scene, ray, box);
    const glm::dvec3 wi = glm::normalize(sun.direction_to_light);
    const double phase = phase_henyey_greenstein(glm::dot(wi, ray.direction), double(box.g));
    // Per metre of the eye's ray, metres of the sun's: inwards from the face that the sun is on.
    const double k = std::abs(ray.direction.y / wi.y);
    glm::dvec3 radiance;
    for (int c = 0; c < 3; ++c) {
        const double sigma_s = box.sigma_s[c], sigma_t = sigma_s + double(box.sigma_a[c]);
        // exp(-sigma_t s) to the eye, exp(-sigma_t k s) or exp(-sigma_t k (length - s)) to the sun.
        const double rate = sigma_t * (wi.y > 0 ? 1 + k : 1 - k);
        const double at_entry = wi.y > 0 ? 1 : std::exp(-sigma_t * k * length);
        const double integral = std::abs(rate) < 1e-9 ? length : -std::expm1(-rate * length) / rate;
        radiance[c] = double(sun.irradiance[c]) * sigma_s * phase * at_entry * integral;
    }
    return radiance;
}

std::shared_ptr<VoxelGrid> make_grid(glm::ivec3 bricks, const glm::dmat4& world_from_index,
                                     const std::function<double(glm::ivec3)>& value,
                                     glm::ivec3 first)
{
    auto grid = std::make_shared<VoxelGrid>();
    grid->name = "density";
    grid->world_from_index = world_from_index;
    glm::ivec3 low{1 << 30}, high{-(1 << 30)};
    for (int bz = 0; bz < bricks.z; ++bz)
        for (int by = 0; by < bricks.y; ++by)
            for (int bx = 0; bx < bricks.x; ++bx) {
                const glm::ivec3 brick = first + glm::ivec3(bx, by, bz);
                grid->bricks.push_back(brick);
                for (int i = 0; i < VoxelGrid::kBrickVoxels; ++i) {
                    const glm::ivec3 at = brick * 8 + glm::ivec3(i & 7, (i >> 3) & 7, i >> 6);
                    const auto v = static_cast<float>(value(at));
                    grid->values.push_back(v);
                    if (v == 0)
                        continue;
                    low = glm::min(low, at);
                    high = glm::max(high, at);
                    grid->max_value = std::max(grid->max_value, v);
                    ++grid->active_voxels;
                }
            }
    if (grid->active_voxels > 0) {
        grid->index_min = low;
        grid->index_max = high;
    }
    return grid;
}

glm::dmat4 voxels(double size, glm::dvec3 at)
{
    return {size, 0, 0, 0, 0, size, 0, 0, 0, 0, size, 0, at.x, at.y, at.z, 1};
}

GridMedium lump(double sigma_s, double sigma_a)
{
    GridMedium smoke;
    smoke.density = make_grid({3, 3, 3}, voxels(0.125, {-1.45, -6.45, -1.45}), [](glm::ivec3 v) {
        const glm::dvec3 p = (glm::dvec3(v) - glm::dvec3(11.5, 11.0, 12.0)) / 11.0;
        const double r2 = glm::dot(p, p);
        const double ripple = 1 + 0.5 * p.x + 0.4 * std::sin(9 * p.x + 4 * p.z) * std::sin(7 * p.y);
        return r2 < 1 ? (1 - r2) * ripple : 0.0;
    });
    smoke.sigma_s_per_density = glm::vec3(static_cast<float>(sigma_s));
    smoke.sigma_a_per_density = glm::vec3(static_cast<float>(sigma_a));
    smoke.g = 0.3f;
    return smoke;
}

Scene full_scene(double unit, glm::dvec3 origin, bool surfaces)
{
    const auto at = [&](double x, double y, double z) {
        return origin + glm::dvec3(x, y, z) * unit;
    };
    const auto per_metre = [&](float r, float g, float b) {
        return glm::vec3(r, g, b) / static_cast<float>(unit);
    };
    Scene scene = bare_scene(32);
    scene.camera.position = at(0, 0, 1);
    scene.camera.look_at = at(0, -5, 0.5);
    scene.camera.vfov_deg = 50;
    scene.camera.near *= unit;
    scene.camera.far *= unit;
    scene.world.radiance = {0.1f, 0.2f, 0.3f};
    const auto intensity = static_cast<float>(unit * unit);
    scene.lights = {SunLight{{0.7, 0.3, 0.6}, glm::vec3(3)},
                    PointLight{at(1.2, -4, 1.5), glm::vec3(4, 3, 2) * intensity},
                    SpotLight{at(-1, -4, 3), {0.1, -0.1, -1}, 50, 0.4, glm::vec3(6) * intensity}};
    GridMedium smoke;
    smoke.density =
        make_grid({2, 2, 2}, voxels(0.19 * unit, at(-1.57, -7.03, 0.13)), [](glm::ivec3 i) {
            const glm::dvec3 q = (glm::dvec3(i) - 7.5) / 8.0;
            return std::max(0.0, 1 - glm::dot(q, q));
        });
    smoke.sigma_s_per_density = per_metre(0.5f, 0.7f, 1.0f);
    smoke.sigma_a_per_density = per_metre(0.2f, 0.2f, 0.2f);
    smoke.g = 0.4f;
    BoxMedium fog;
    fog.min = at(-19.97, -20.06, 0);
    fog.max = at(20.03, 2.04, 7.98);
    fog.sigma_s = per_metre(0.05f, 0.05f, 0.05f);
    fog.emission = per_metre(0.01f, 0, 0);
    fog.profile = ExpHeightProfile{.scale_height = 1.5 * unit, .z0 = origin.z};
    fog.g = 0.6f;
    scene.media = {smoke, fog};
    if (surfaces)
        scene.surfaces = {SphereSurface{at(0.5, -5.5, 0.6), 0.5 * unit, glm::vec3(0.5f)},
                          BoxSurface{at(-20, -20, -1), at(20, 20, 0), glm::vec3(0.3f)}};
    return scene;
}

Settings StabilityBench::with(std::string_view name, std::string_view value) const
{
    Settings changed = settings;
    find_setting(name).set(changed, value);
    return changed;
}

Settings StabilityBench::full_size() const
{
    Settings full = settings;
    full.resolution = 1;
    full.tile = 1;
    return full;
}

std::vector<Settings> StabilityBench::small_layers() const
{
    if (settings.mode == Settings::Mode::froxel)
        return {settings};
    return {with("resolution", "half"), with("resolution", "quarter")};
}

Settings StabilityBench::march_alone(int steps) const
{
    Settings alone = full_size();
    alone.steps = alone.slices = steps;
    alone.jitter = Settings::Jitter::none;
    alone.spacing = Settings::Spacing::fixed;  // so many, and no fewer
    alone.format = Settings::Format::rgba32f;
    alone.storage = medium::Storage::r32f;
    return alone;
}

Still StabilityBench::render(const Scene& scene, const Settings& with, std::uint32_t frame) const
{
    StillOptions options;
    options.seed = frame;
    return renderer_.render(scene, with, options);
}

Picture StabilityBench::over_white(const Scene& scene, const Settings& with,
                                   const std::function<double(int x, int y)>& view_z) const
{
    const glm::ivec2 size(scene.resolution);
    HostPicture host(renderer().device(), scene.camera, scene.resolution);
    const glm::dmat4& p = host.frame.clip_from_view;
    std::vector<float> depths;
    for (int y = size.y - 1; y >= 0; --y)
        for (int x = 0; x < size.x; ++x) {
            const double z = view_z(x, y);
            depths.push_back(
                z == 0 ? 0.0f
                       : static_cast<float>((p[2][2] * -z + p[3][2]) / (p[2][3] * -z + p[3][3])));
        }
    const std::vector<float> white(4 * depths.size(), 1.0f);
    host.color.upload(GL_RGBA, GL_FLOAT, white.data());
    host.depth.upload(GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
    renderer().set_scene(scene, with);
    renderer().wait_until_ready();
    View view = renderer().make_view(View::History::none);
    renderer().composite(view, host.frame, with);
    return host.read();
}

Picture StabilityBench::gathered(const Scene& scene, const Settings& with, int frames) const
{
    StabilityView view(*this, with);
    view.set_scene(scene);
    for (int i = 1; i < frames; ++i)
        (void)view.draw(scene);
    return view.draw(scene);
}

StabilityView::StabilityView(const StabilityBench& bench, Settings settings)
    : renderer_{bench.renderer()}, view_{renderer_.make_view()}, settings_{settings}
{
}

void StabilityView::set_scene(const Scene& scene)
{
    renderer_.set_scene(scene, settings_);
    renderer_.wait_until_ready();
}

Picture StabilityView::draw(const Camera& camera, glm::uvec2 size)
{
    HostPicture host(renderer_.device(), camera, size);
    host.frame.index = frames_++;
    host.frame.jitter_offset = golden_fraction(static_cast<double>(host.frame.index));
    renderer_.draw_surfaces(host.frame, settings_, true);
    renderer_.composite(view_, host.frame, settings_);
    return host.read();
}

}  // namespace fumarole::study
