#include "study/reference_transparents.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "overloaded.h"

namespace fumarole::study {

namespace {

glm::dvec4 factor(BlendFactor name, glm::dvec4 source, glm::dvec4 behind)
{
    switch (name) {
    case BlendFactor::zero:
        return glm::dvec4(0);
    case BlendFactor::one:
        return glm::dvec4(1);
    case BlendFactor::src_color:
        return source;
    case BlendFactor::one_minus_src_color:
        return 1.0 - source;
    case BlendFactor::dst_color:
        return behind;
    case BlendFactor::one_minus_dst_color:
        return 1.0 - behind;
    case BlendFactor::src_alpha:
        return glm::dvec4(source.a);
    case BlendFactor::one_minus_src_alpha:
        return glm::dvec4(1 - source.a);
    case BlendFactor::dst_alpha:
        return glm::dvec4(behind.a);
    case BlendFactor::one_minus_dst_alpha:
        return glm::dvec4(1 - behind.a);
    case BlendFactor::src_alpha_saturate:
        break;
    }
    return {glm::dvec3(std::min(source.a, 1 - behind.a)), 1};
}

/// Between the middles of texels, and as the outermost ones beyond them. `at` is 0..1 from the
/// lower left.
glm::dvec4 texture(const TransparentImage& image, glm::dvec2 at)
{
    const double x = at.x * image.width - 0.5, y = (1 - at.y) * image.height - 0.5;
    const auto texel = [&](double column, double row) {
        const int i = std::clamp(static_cast<int>(column), 0, image.width - 1);
        const int j = std::clamp(static_cast<int>(row), 0, image.height - 1);
        return glm::dvec4(
            image.texels[static_cast<std::size_t>(j) * static_cast<std::size_t>(image.width) +
                         static_cast<std::size_t>(i)]);
    };
    const double left = std::floor(x), top = std::floor(y);
    const glm::dvec4 above = glm::mix(texel(left, top), texel(left + 1, top), x - left);
    const glm::dvec4 below = glm::mix(texel(left, top + 1), texel(left + 1, top + 1), x - left);
    return glm::mix(above, below, y - top);
}

/// A look at a place, before a surface that is `clear` metres behind it.
TransparentHit shade(const TransparentLook& look, glm::dvec2 at, double clear)
{
    using Kind = Blend::Kind;
    const Kind kind = look.blend.kind;
    const double fade = look.depth_fade > 0
                            ? std::clamp(clear / static_cast<double>(look.depth_fade), 0.0, 1.0)
                            : 1.0;
    TransparentHit hit;
    const bool filters = kind == Kind::multiply;
    glm::dvec4 own(filters ? look.filter : look.radiance, static_cast<double>(look.alpha));
    const bool image = look.image != nullptr;
    if (image) {
        own = static_cast<double>(look.alpha) * texture(*look.image, at);
        if (filters)  // what the image does not cover is clear
            own = {glm::dvec3(own) * static_cast<double>(look.scale) + (1 - own.a), 1};
        else
            own = {glm::dvec3(own) * static_cast<double>(look.scale), own.a};
    }
    switch (kind) {
    case Kind::alpha:
        own.a *= fade;
        // An image's colours are multiplied by its alpha.
        hit.source_factor = image ? BlendFactor::one : BlendFactor::src_alpha;
        hit.destination_factor = BlendFactor::one_minus_src_alpha;
        if (image)
            own = {glm::dvec3(own) * fade, own.a};
        break;
    case Kind::premultiplied:
        own *= fade;
        hit.destination_factor = BlendFactor::one_minus_src_alpha;
        break;
    case Kind::add:
        own = {glm::dvec3(own) * fade, own.a};
        hit.destination_factor = BlendFactor::one;
        break;
    case Kind::multiply:
        own = {glm::mix(glm::dvec3(1), glm::dvec3(own), fade), 1};
        hit.source_factor = BlendFactor::zero;
        hit.destination_factor = BlendFactor::src_color;
        break;
    case Kind::factors:
        own.a *= fade;
        hit.source_factor = look.blend.source;
        hit.destination_factor = look.blend.destination;
        break;
    }
    hit.source = own;
    return hit;
}

/// Metres along the ray to a parallelogram, and where on it, 0..1.
std::optional<double> meet(const Ray& ray, glm::dvec3 corner, glm::dvec3 across, glm::dvec3 up,
                           glm::dvec2& at)
{
    const glm::dvec3 normal = glm::cross(across, up);
    const double slope = glm::dot(ray.direction, normal);
    if (slope == 0)
        return std::nullopt;
    const double t = glm::dot(corner - ray.origin, normal) / slope;
    const glm::dvec3 p = ray.at(t) - corner;
    const double area = glm::dot(normal, normal);
    at = {glm::dot(glm::cross(p, up), normal) / area,
          glm::dot(glm::cross(across, p), normal) / area};
    if (!(at.x >= 0 && at.x <= 1 && at.y >= 0 && at.y <= 1))
        return std::nullopt;
    return t;
}

}  // namespace

glm::dvec4 TransparentHit::kept(glm::dvec4 behind) const
{
    return factor(destination_factor, source, behind);
}

glm::dvec4 TransparentHit::over(glm::dvec4 behind) const
{
    return source * factor(source_factor, source, behind) + behind * kept(behind);
}

ReferenceTransparents::ReferenceTransparents(const Scene& scene)
{
    const glm::dvec3 forward = glm::normalize(scene.camera.look_at - scene.camera.position);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, scene.camera.up));
    const glm::dvec3 up = glm::cross(right, forward);
    for (const Transparent& transparent : scene.transparents) {
        Shape shape;
        shape.look = &look_of(transparent);
        std::visit(Overloaded{[&](const QuadTransparent& quad) {
                                  shape.corner = quad.corner;
                                  shape.across = quad.edges[0];
                                  shape.up = quad.edges[1];
                              },
                              [&](const BillboardTransparent& board) {
                                  shape.across = board.size.x * right;
                                  shape.up = board.size.y * up;
                                  shape.corner = board.center - (shape.across + shape.up) / 2.0;
                              },
                              [&](const MeshTransparent& mesh) {
                                  if (mesh.mesh == nullptr)
                                      return;
                                  shape.mesh = std::make_unique<const std::vector<Surface>>(
                                      std::vector<Surface>{MeshSurface{
                                          mesh.file, mesh.mesh, mesh.translate, mesh.scale, {}}});
                              }},
                   transparent);
        if (shape.mesh != nullptr)
            shape.surfaces = std::make_unique<ReferenceSurfaces>(*shape.mesh);
        casts_ = casts_ || shape.look->casts;
        shapes_.push_back(std::move(shape));
    }
}

ReferenceTransparents::~ReferenceTransparents() = default;

std::vector<TransparentHit> ReferenceTransparents::along(const Ray& ray, double begin, double far,
                                                         double surface) const
{
    const double end = std::min(far, surface);
    std::vector<TransparentHit> hits;
    const auto add = [&](const Shape& shape, double t, glm::dvec2 at) {
        TransparentHit hit = shade(*shape.look, at, surface - t);
        hit.t = t;
        hit.index = static_cast<std::size_t>(&shape - shapes_.data());
        hits.push_back(hit);
    };
    // The last one first, so that a stable sort leaves it in front.
    for (auto shape = shapes_.rbegin(); shape != shapes_.rend(); ++shape) {
        if (shape->surfaces != nullptr) {
            double from = begin;
            while (const auto hit = shape->surfaces->intersect(ray, from, end)) {
                add(*shape, hit->t, glm::dvec2(0));
                from = hit->t;
            }
            continue;
        }
        glm::dvec2 at(0);
        const auto t = meet(ray, shape->corner, shape->across, shape->up, at);
        if (t && *t > begin && *t < end)
            add(*shape, *t, at);
    }
    std::stable_sort(hits.begin(), hits.end(),
                     [](const TransparentHit& a, const TransparentHit& b) { return a.t < b.t; });
    return hits;
}

glm::dvec3 ReferenceTransparents::filter(const Ray& ray, double range) const
{
    glm::dvec3 passed(1);
    const auto meets = [&](const Shape& shape, glm::dvec2 at) {
        passed *= glm::dvec3(shade(*shape.look, at, kInfinity).kept(glm::dvec4(0)));
    };
    for (const Shape& shape : shapes_) {
        if (!shape.look->casts)
            continue;
        if (shape.surfaces != nullptr) {
            double from = 0;
            while (const auto hit = shape.surfaces->intersect(ray, from, range)) {
                meets(shape, glm::dvec2(0));
                from = hit->t;
            }
            continue;
        }
        glm::dvec2 at(0);
        const auto t = meet(ray, shape.corner, shape.across, shape.up, at);
        if (t && *t > 0 && *t < range)
            meets(shape, at);
    }
    return passed;
}

std::function<glm::dvec3(double)> ReferenceTransparents::along_way(const Ray& ray) const
{
    if (!casts_)
        return {};
    return [this, ray](double range) { return filter(ray, range); };
}

void ReferenceTransparents::add_filter_breaks(const Ray& ray, double begin, double end,
                                              const LightPlace& light,
                                              std::vector<double>& breaks) const
{
    const auto add = [&](double t) {
        if (t > begin && t < end)
            breaks.push_back(t);
    };
    // Where the ray meets the plane through a point that is square to n.
    const auto cross_plane = [&](glm::dvec3 point, glm::dvec3 n) {
        if (const double slope = glm::dot(ray.direction, n); slope != 0)
            add(glm::dot(point - ray.origin, n) / slope);
    };
    bool meshes = false;
    for (const Shape& shape : shapes_) {
        if (!shape.look->casts)
            continue;
        if (shape.surfaces != nullptr) {
            meshes = true;
            continue;
        }
        cross_plane(shape.corner, glm::cross(shape.across, shape.up));
        // The planes through the light and an edge.
        for (const auto& [point, edge] :
             {std::pair(shape.corner, shape.across), std::pair(shape.corner, shape.up),
              std::pair(shape.corner + shape.up, shape.across),
              std::pair(shape.corner + shape.across, shape.up)})
            cross_plane(point, glm::cross(edge, light.far ? light.at : point - light.at));
    }
    if (!meshes)
        return;
    // Of a mesh: look, and halve where the answer changes.
    const auto seen = [&](double t) {
        const glm::dvec3 p = ray.at(t);
        return filter({p, light.wi(p)}, light.range(p));
    };
    constexpr int kLooks = 128, kHalvings = 40;
    const double far = std::min(end, 1e9);
    double t0 = begin;
    glm::dvec3 seen0 = seen(t0);
    for (int i = 1; i <= kLooks; ++i) {
        const double t1 = begin + (far - begin) * i / kLooks;
        const glm::dvec3 seen1 = seen(t1);
        double a = t0, b = t1;
        for (int halving = 0; halving < kHalvings && seen1 != seen0; ++halving) {
            const double middle = (a + b) / 2;
            (seen(middle) == seen0 ? a : b) = middle;
        }
        if (seen1 != seen0)
            add(b);
        t0 = t1;
        seen0 = seen1;
    }
}

}  // namespace fumarole::study
