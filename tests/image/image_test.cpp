#include "image_test.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <numbers>

namespace fumarole::test {

Settings ImageTest::plain_settings(int resolution)
{
    Settings settings;
    settings.resolution = resolution;
    settings.steps = 64;
    settings.spacing = Settings::Spacing::fixed;
    settings.falloff = Settings::Falloff::sampled;
    settings.jitter = Settings::Jitter::none;
    settings.format = Settings::Format::rgba32f;
    settings.storage = medium::Storage::r32f;
    settings.bounces = 0;
    settings.shadow_map = 256;  // large ones are cleared at a cost, and no test here looks closely
    return settings;
}

Settings ImageTest::plain_froxels(int tile)
{
    Settings settings = plain_settings();
    settings.mode = Settings::Mode::froxel;
    settings.tile = tile;
    return settings;
}

PixelRay ImageTest::ray_at(const Scene& scene, glm::dvec2 at)
{
    const Camera& camera = scene.camera;
    const glm::dvec2 size(scene.resolution);
    const glm::dvec2 ndc(2 * at.x / size.x - 1, 1 - 2 * at.y / size.y);
    const double aspect = size.x / size.y;
    const glm::dvec3 forward = glm::normalize(camera.look_at - camera.position);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, camera.up));
    const glm::dvec3 up = glm::cross(right, forward);
    if (camera.projection == Camera::Projection::orthographic) {
        const double half = camera.ortho_height / 2;
        return {camera.position + right * (ndc.x * half * aspect) + up * (ndc.y * half), forward,
                1};
    }
    const double tangent = std::tan(camera.vfov_deg * std::numbers::pi / 360);
    const glm::dvec3 direction =
        forward + right * (ndc.x * tangent * aspect) + up * (ndc.y * tangent);
    return {camera.position, glm::normalize(direction), glm::length(direction)};
}

Image ImageTest::picture_of(const Still& still, const std::vector<float>& rgb)
{
    return {still.width, still.height, {"R", "G", "B"}, rgb};
}

Image ImageTest::ideal(const Scene& scene, const PictureField& field)
{
    const glm::ivec2 size(scene.resolution);
    Image image{size.x, size.y, {"R", "G", "B"}, {}};
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const glm::dvec3 value = field({x + 0.5, y + 0.5});
            for (int c = 0; c < 3; ++c)
                image.pixels.push_back(static_cast<float>(value[c]));
        }
    return image;
}

Image ImageTest::resolved(const Scene& scene, int resolution, const PictureField& field)
{
    const glm::ivec2 size(scene.resolution);
    // One texel around the picture is the layer's guard band.
    const glm::ivec2 layer = (size + resolution - 1) / resolution + 2;
    // Layer rows are counted from the bottom, as GL does: it matters where the height is odd.
    std::vector<glm::dvec3> texels;
    for (int y = -1; y < layer.y - 1; ++y)
        for (int x = -1; x < layer.x - 1; ++x)
            texels.push_back(field({(x + 0.5) * resolution, size.y - (y + 0.5) * resolution}));
    const auto texel = [&](int x, int y) {
        return texels[static_cast<std::size_t>(y + 1) * static_cast<std::size_t>(layer.x) +
                      static_cast<std::size_t>(x + 1)];
    };
    return ideal(scene, [&](glm::dvec2 at) {
        const glm::dvec2 position = glm::dvec2(at.x, size.y - at.y) / double(resolution) - 0.5;
        const glm::dvec2 low = glm::floor(position);
        const glm::dvec2 f = position - low;
        const int x = static_cast<int>(low.x), y = static_cast<int>(low.y);
        return glm::mix(glm::mix(texel(x, y), texel(x + 1, y), f.x),
                        glm::mix(texel(x, y + 1), texel(x + 1, y + 1), f.x), f.y);
    });
}

double ImageTest::max_difference(const Image& a, const Image& b)
{
    double worst = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        worst = std::max(worst, std::abs(double(a.pixels[i]) - double(b.pixels[i])));
    return worst;
}

double ImageTest::rms_difference(const Image& a, const Image& b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        sum += std::pow(double(a.pixels[i]) - double(b.pixels[i]), 2);
    return std::sqrt(sum / static_cast<double>(a.pixels.size()));
}

void ImageTest::figure(std::string_view name, double value)
{
    RecordProperty(std::string(name), fmt::format("{:.3g}", value));
    if (std::getenv("FUM_TEST_FIGURES") != nullptr)
        fmt::print("[  figure  ] {} = {:.3g}\n", name, value);
}

Segment box_segment(const PixelRay& ray, glm::dvec3 min, glm::dvec3 max, double near)
{
    Segment inside{near, 1e300};
    for (int axis = 0; axis < 3; ++axis) {
        const double a = (min[axis] - ray.origin[axis]) / ray.direction[axis];
        const double b = (max[axis] - ray.origin[axis]) / ray.direction[axis];
        if (ray.direction[axis] == 0) {
            if (ray.origin[axis] < min[axis] || ray.origin[axis] > max[axis])
                return {};
            continue;
        }
        inside.begin = std::max(inside.begin, std::min(a, b));
        inside.end = std::min(inside.end, std::max(a, b));
    }
    return inside;
}

double integrate(double begin, double end, int panels, const std::function<double(double)>& f)
{
    // Abramowitz and Stegun 25.4.30, n = 5.
    constexpr std::array kNode{-0.906179845938664, -0.538469310105683, 0.0, 0.538469310105683,
                               0.906179845938664};
    constexpr std::array kWeight{0.236926885056189, 0.478628670499366, 0.568888888888889,
                                 0.478628670499366, 0.236926885056189};
    const double half = (end - begin) / panels / 2;
    double sum = 0;
    for (int i = 0; i < panels; ++i)
        for (std::size_t k = 0; k < kNode.size(); ++k)
            sum += kWeight[k] * f(begin + half * (2 * i + 1 + kNode[k]));
    return sum * half;
}

double henyey_greenstein(double cos_theta, double g)
{
    return (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * cos_theta, 1.5));
}

std::shared_ptr<VoxelGrid> lump(const glm::dmat4& world_from_index)
{
    return make_grid({2, 2, 2}, world_from_index, [](glm::ivec3 v) {
        const glm::dvec3 p = (glm::dvec3(v) - glm::dvec3(7.5, 7.0, 8.0)) / glm::dvec3(7, 6, 7);
        const double r2 = glm::dot(p, p);
        return r2 < 1 ? (1 - r2) * (1 + 0.5 * p.x) : 0.0;
    });
}

double grid_column(const VoxelLookup& grid, const glm::dmat4& index_from_world, glm::dvec3 p,
                   glm::dvec3 direction, Segment segment, int panels)
{
    const glm::dvec3 from(index_from_world * glm::dvec4(p, 1));
    const glm::dvec3 along(index_from_world * glm::dvec4(direction, 0));
    if (segment.length() == 0)
        return 0;
    return integrate(segment.begin, segment.end, panels,
                     [&](double t) { return grid.sample(from + along * t).x; });
}

}  // namespace fumarole::test
