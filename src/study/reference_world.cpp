#include "study/reference_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <oneapi/tbb/collaborative_call_once.h>
#include <oneapi/tbb/concurrent_hash_map.h>
#include <oneapi/tbb/parallel_for.h>
#include <unordered_map>

#include "study/reference.h"
#include "study/reference_quadrature.h"

namespace fumarole::study {

namespace {

constexpr double kPi = std::numbers::pi;
/// Depth of the lattices: 2^kDeepest cells along an edge at most.
constexpr int kDeepest = 18;
/// Bands of spherical harmonics at most in the lattices, and where a place is asked itself: the
/// latter's are enough for |g| to 0.65 at 0.1 %, where g^16 is 1e-3.
constexpr int kMostLatticeBands = 9, kMostBands = 17;
/// Nodes of a lattice: 100 MB at most, and a minute or two.
constexpr std::size_t kMostNodes = 150000;
/// What trilinear interpolation may miss where the quadratic one is used: that is better by about
/// the ratio of two steps' cubes, 8.
constexpr double kQuadraticGain = 4;

glm::dvec3 direction(double z, double phi)
{
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Real spherical harmonics of `bands` bands: value l * l + l + m is Y_lm. Recurrences of the
/// associated Legendre functions, normalised as they go.
void spherical_harmonics(glm::dvec3 d, int bands, std::vector<double>& out)
{
    out.resize(static_cast<std::size_t>(bands) * static_cast<std::size_t>(bands));
    const auto y = [&](int l, int m) -> double& {
        return out[static_cast<std::size_t>(l * l + l + m)];
    };
    // P_mm without sin^m, which x and y bring: cos(m phi) sin^m = Re (x + i y)^m.
    double diagonal = std::sqrt(1 / (4 * kPi)), re = 1, im = 0;
    for (int m = 0; m < bands; ++m) {
        double before = 0, here = diagonal;
        for (int l = m; l < bands; ++l) {
            const double scale = m == 0 ? 1 : std::numbers::sqrt2;
            y(l, m) = scale * here * re;
            if (m > 0)
                y(l, -m) = scale * here * im;
            const double l1 = l + 1;
            const double a = std::sqrt((4 * l1 * l1 - 1) / (l1 * l1 - m * m));
            const double b = std::sqrt((l * double(l) - m * m) / (4.0 * l * l - 1));
            const double next = a * (d.z * here - (l > m ? b * before : 0.0));
            before = here;
            here = next;
        }
        diagonal *= -std::sqrt((2.0 * m + 3) / (2.0 * m + 2));
        const double re_next = re * d.x - im * d.y;
        im = re * d.y + im * d.x;
        re = re_next;
    }
}

/// Adaptive quadrature over a square whose points are directions of equal weight. A patch is seen
/// through 2 x 2 points of Gauss; where its four quarters say something else, they are cut again.
template <int N> class PatchQuadrature {
public:
    using Value = std::array<double, N>;
    using Patch = WorldRadiance::Patch;
    struct Sample {
        double x, y, weight;
        Value value;
    };

    /// f(x, y) -> Value; the samples' weights add up to the patches' area.
    template <class F>
    double run(const std::vector<Patch>& patches, const F& f, double relative, double absolute)
    {
        groups_.clear();
        std::vector<std::size_t> heap;
        const auto worse = [&](std::size_t a, std::size_t b) {
            return groups_[a].error < groups_[b].error;
        };
        Value sum{};
        double squares = 0;
        const auto push = [&](const Group& group) {
            for (std::size_t c = 0; c < N; ++c)
                sum[c] += group.sum[c];
            squares += group.error * group.error;
            groups_.push_back(group);
            heap.push_back(groups_.size() - 1);
            std::push_heap(heap.begin(), heap.end(), worse);
        };
        for (const Patch& patch : patches)
            push(make(patch, look(patch, f), f));
        // Errors of many patches, each of any sign.
        const auto good = [&] {
            double size = 0;
            for (const double v : sum)
                size = std::max(size, std::abs(v));
            return std::sqrt(std::max(squares, 0.0)) <= std::max(absolute, relative * size);
        };
        constexpr std::size_t kMostGroups = 4096;
        while (!good() && groups_.size() < kMostGroups) {
            std::pop_heap(heap.begin(), heap.end(), worse);
            const std::size_t worst = heap.back();
            heap.pop_back();
            groups_[worst].split = true;
            const Group group = groups_[worst];
            squares -= group.error * group.error;
            for (std::size_t c = 0; c < N; ++c)
                sum[c] -= group.sum[c];
            for (std::size_t q = 0; q < 4; ++q)
                push(make(quarter(group.patch, q), group.quarters[q], f));
        }
        return std::sqrt(std::max(squares, 0.0));
    }

    template <class Use> void for_each(const Use& use) const
    {
        for (const Group& group : groups_)
            if (!group.split)
                for (const auto& samples : group.quarters)
                    for (const Sample& sample : samples)
                        use(sample);
    }

private:
    using Look = std::array<Sample, 4>;
    struct Group {
        Patch patch;
        std::array<Look, 4> quarters;
        Value sum{};
        double error = 0;
        bool split = false;
    };

    static Patch quarter(const Patch& p, std::size_t q)
    {
        const double z = (p.z0 + p.z1) / 2, phi = (p.phi0 + p.phi1) / 2;
        return {(q & 1) != 0 ? z : p.z0, (q & 1) != 0 ? p.z1 : z, (q & 2) != 0 ? phi : p.phi0,
                (q & 2) != 0 ? p.phi1 : phi};
    }

    template <class F> static Look look(const Patch& p, const F& f)
    {
        constexpr double kNode = 0.21132486540518712;
        const double dz = p.z1 - p.z0, dphi = p.phi1 - p.phi0;
        Look samples;
        for (std::size_t q = 0; q < 4; ++q) {
            Sample& s = samples[q];
            s.x = p.z0 + dz * ((q & 1) != 0 ? 1 - kNode : kNode);
            s.y = p.phi0 + dphi * ((q & 2) != 0 ? 1 - kNode : kNode);
            s.weight = dz * dphi / 4;
            s.value = f(s.x, s.y);
        }
        return samples;
    }

    template <class F> static Group make(const Patch& patch, const Look& coarse, const F& f)
    {
        Group group;
        group.patch = patch;
        Value difference{}, local{};
        for (std::size_t q = 0; q < 4; ++q) {
            group.quarters[q] = look(quarter(patch, q), f);
            for (std::size_t c = 0; c < N; ++c) {
                double fine = 0;
                for (const Sample& s : group.quarters[q])
                    fine += s.weight * s.value[c];
                group.sum[c] += fine;
                const double change = fine - coarse[q].weight * coarse[q].value[c];
                difference[c] += change;
                local[c] += std::abs(change);
            }
        }
        // The sum of the changes, and a little of each, which may cancel by chance.
        for (std::size_t c = 0; c < N; ++c)
            group.error = std::max(group.error, 0.5 * std::abs(difference[c]) + 0.05 * local[c]);
        return group;
    }

    std::vector<Group> groups_;
};

std::array<double, 3> weights(double u)
{
    return {2 * (u - 0.5) * (u - 1), 4 * u * (1 - u), 2 * u * (u - 0.5)};
}

double distance(const Bounds& a, const Bounds& b)
{
    const glm::dvec3 gap = glm::max(glm::max(a.min - b.max, b.min - a.max), glm::dvec3(0));
    return glm::length(gap);
}

struct Key {
    int space = 0, level = 0;
    glm::ivec3 index{0};
    bool operator==(const Key&) const = default;
};

struct KeyHash {
    static std::size_t hash(const Key& key)
    {
        std::uint64_t h = 0;
        for (const int part : {key.space, key.level, key.index.x, key.index.y, key.index.z}) {
            h = (h ^ static_cast<std::uint32_t>(part)) * 0x9e3779b97f4a7c15u;
            h ^= h >> 29u;
        }
        return static_cast<std::size_t>(h);
    }
    static bool equal(const Key& a, const Key& b) { return a == b; }
};

/// Values by key, each worked out once by whoever asks first; the others wait for it.
template <class Value> class Store {
public:
    template <class Make> const Value& get(const Key& key, const Make& make)
    {
        {
            typename Map::const_accessor found;
            if (map_.find(found, key) && found->second)
                return *found->second;
        }
        typename Map::accessor made;
        map_.insert(made, key);
        if (!made->second)
            made->second = std::make_unique<Value>(make());
        return *made->second;
    }
    [[nodiscard]] std::size_t size() const { return map_.size(); }

private:
    using Map = oneapi::tbb::concurrent_hash_map<Key, std::unique_ptr<Value>, KeyHash>;
    Map map_;
};

}  // namespace

// ------------------------------------------------------------------------------ what is seen

WorldRadiance::WorldRadiance(const World& world)
{
    constexpr int kRows = 4, kColumns = 8;
    if (world.environment == nullptr) {
        constant_ = mean_ = world.radiance;
    } else {
        map_ = world.environment.get();
        scale_ = static_cast<double>(world.environment_scale);
        for (int y = 0; y < map_->height; ++y) {
            const double solid_angle =
                2 * kPi / map_->width *
                (std::cos(kPi * y / map_->height) - std::cos(kPi * (y + 1) / map_->height));
            for (int x = 0; x < map_->width; ++x)
                mean_ += scale_ * solid_angle / (4 * kPi) *
                         glm::dvec3(map_->radiance[static_cast<std::size_t>(y) *
                                                       static_cast<std::size_t>(map_->width) +
                                                   static_cast<std::size_t>(x)]);
        }
        total_ = 4 * kPi * largest(mean_);
    }
    if (!black())
        patches_ = cut(kRows, kColumns, 1.0 / 48);
}

std::vector<WorldRadiance::Patch> WorldRadiance::cut(int rows, int columns, double most_light) const
{
    std::vector<Patch> patches;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column)
            cut({-1 + 2.0 * row / rows, -1 + 2.0 * (row + 1) / rows,
                 -kPi + 2 * kPi * column / columns, -kPi + 2 * kPi * (column + 1) / columns},
                most_light, 0, patches);
    return patches;
}

void WorldRadiance::cut(const Patch& patch, double most_light, int depth,
                        std::vector<Patch>& patches) const
{
    constexpr int kDeepestCut = 8;
    if (map_ == nullptr || depth == kDeepestCut || light_in(patch) <= most_light * total_) {
        patches.push_back(patch);
        return;
    }
    const double z = (patch.z0 + patch.z1) / 2, phi = (patch.phi0 + patch.phi1) / 2;
    cut({patch.z0, z, patch.phi0, phi}, most_light, depth + 1, patches);
    cut({z, patch.z1, patch.phi0, phi}, most_light, depth + 1, patches);
    cut({patch.z0, z, phi, patch.phi1}, most_light, depth + 1, patches);
    cut({z, patch.z1, phi, patch.phi1}, most_light, depth + 1, patches);
}

double WorldRadiance::light_in(const Patch& patch) const
{
    // Texels by their centres are enough to know where the light is.
    const auto row = [&](double z) { return std::acos(std::clamp(z, -1.0, 1.0)) / kPi; };
    const int y0 = static_cast<int>(row(patch.z1) * map_->height);
    const int y1 = std::min(map_->height - 1, static_cast<int>(row(patch.z0) * map_->height));
    const auto column = [&](double phi) { return (0.5 - phi / (2 * kPi)) * map_->width; };
    const int x0 = std::max(0, static_cast<int>(column(patch.phi1)));
    const int x1 = std::min(map_->width - 1, static_cast<int>(column(patch.phi0)));
    double light = 0;
    for (int y = y0; y <= y1; ++y) {
        const double solid_angle =
            2 * kPi / map_->width *
            (std::cos(kPi * y / map_->height) - std::cos(kPi * (y + 1) / map_->height));
        for (int x = x0; x <= x1; ++x)
            light += scale_ * solid_angle *
                     largest(glm::dvec3(map_->radiance[static_cast<std::size_t>(y) *
                                                           static_cast<std::size_t>(map_->width) +
                                                       static_cast<std::size_t>(x)]));
    }
    return light;
}

glm::dvec3 WorldRadiance::operator()(glm::dvec3 d) const
{
    if (map_ == nullptr)
        return constant_;
    // Between texels' centres: around in u, held at the poles in v.
    const double u = (0.5 - std::atan2(d.y, d.x) / (2 * kPi)) * map_->width - 0.5;
    const double v = std::acos(std::clamp(d.z, -1.0, 1.0)) / kPi * map_->height - 0.5;
    const double u0 = std::floor(u), v0 = std::floor(v);
    const auto texel = [&](double x, double y) {
        const int column = ((static_cast<int>(x) % map_->width) + map_->width) % map_->width;
        const int line = std::clamp(static_cast<int>(y), 0, map_->height - 1);
        return glm::dvec3(
            map_->radiance[static_cast<std::size_t>(line) * static_cast<std::size_t>(map_->width) +
                           static_cast<std::size_t>(column)]);
    };
    const double fu = u - u0, fv = v - v0;
    return scale_ * ((texel(u0, v0) * (1 - fu) + texel(u0 + 1, v0) * fu) * (1 - fv) +
                     (texel(u0, v0 + 1) * (1 - fu) + texel(u0 + 1, v0 + 1) * fu) * fv);
}

void WorldRadiance::for_each_texel(const Patch& patch,
                                   const std::function<void(glm::dvec3, glm::dvec3)>& use) const
{
    const auto of_row = [&](int y) { return std::cos(kPi * (y + 0.5) / map_->height); };
    const double columns = map_->width / (2 * kPi);
    const double row0 = std::acos(std::clamp(patch.z1, -1.0, 1.0)) / kPi * map_->height;
    for (int y = std::max(0, static_cast<int>(row0) - 1); y < map_->height; ++y) {
        if (of_row(y) >= patch.z1)
            continue;
        if (of_row(y) < patch.z0)
            break;
        const double solid_angle =
            (std::cos(kPi * y / map_->height) - std::cos(kPi * (y + 1) / map_->height)) / columns;
        const int x0 = std::max(0, static_cast<int>((kPi - patch.phi1) * columns) - 1);
        for (int x = x0; x < map_->width; ++x) {
            const double phi = kPi - (x + 0.5) / columns;
            if (phi >= patch.phi1)
                continue;
            if (phi < patch.phi0)
                break;
            const glm::dvec3 light(
                map_->radiance[static_cast<std::size_t>(y) * static_cast<std::size_t>(map_->width) +
                               static_cast<std::size_t>(x)]);
            use(direction(of_row(y), phi), scale_ * solid_angle * light);
        }
    }
}

// ------------------------------------------------------------------------------------- lattice

/// A direction that stands for those near it, and the harmonics of the light that they bring.
struct ReferenceWorld::Beam {
    glm::dvec3 wi{0};
    std::vector<glm::dvec3> light;
};

/// Nodes on a regular lattice over a medium, wherever it scatters: at each, coefficients of
/// spherical harmonics of what arrives there.
struct ReferenceWorld::MediumLattice {
    glm::dmat4 local_from_world{1.0}, world_from_local{1.0};
    bool graded = false;  ///< a box, 0..1: nodes crowd at its sides, where light changes fastest
    glm::dvec3 first{0}, step{1};  ///< local; not if graded
    glm::ivec3 cells{0};
    std::vector<bool> filled;      ///< by cell: all nodes that interpolation needs are there
    std::vector<int> node_at;      ///< by corner of a cell; -1: none
    std::vector<int> corner_of;    ///< by node
    std::vector<glm::vec3> light;  ///< `harmonics` of them per node
    std::size_t harmonics = 0;
    double size = 0;   ///< of a cell, metres: finer lattices are asked first
    double error = 0;  ///< relative, measured

    [[nodiscard]] std::size_t nodes() const { return corner_of.size(); }
    [[nodiscard]] std::size_t cell_index(glm::ivec3 c) const
    {
        return (static_cast<std::size_t>(c.z) * static_cast<std::size_t>(cells.y) +
                static_cast<std::size_t>(c.y)) *
                   static_cast<std::size_t>(cells.x) +
               static_cast<std::size_t>(c.x);
    }
    [[nodiscard]] std::size_t corner_index(glm::ivec3 c) const
    {
        return (static_cast<std::size_t>(c.z) * static_cast<std::size_t>(cells.y + 1) +
                static_cast<std::size_t>(c.y)) *
                   static_cast<std::size_t>(cells.x + 1) +
               static_cast<std::size_t>(c.x);
    }
    /// Place in the lattice, in cells, to place in the world.
    [[nodiscard]] glm::dvec3 place(glm::dvec3 q) const
    {
        const glm::dvec3 local =
            graded ? 0.5 - 0.5 * glm::cos(kPi * q / glm::dvec3(cells)) : first + q * step;
        return glm::dvec3(world_from_local * glm::dvec4(local, 1));
    }
    /// The cell that p is in, and where; false: it doesn't scatter there.
    bool find(glm::dvec3 p, glm::ivec3& cell, glm::dvec3& in) const
    {
        const glm::dvec3 local(local_from_world * glm::dvec4(p, 1));
        glm::dvec3 q = (local - first) / step;
        if (graded) {
            constexpr double kRounding = 1e-9;
            if (glm::any(glm::lessThan(local, glm::dvec3(-kRounding))) ||
                glm::any(glm::greaterThan(local, glm::dvec3(1 + kRounding))))
                return false;
            q = glm::acos(glm::clamp(1.0 - 2.0 * local, -1.0, 1.0)) / kPi * glm::dvec3(cells);
            q = glm::clamp(q, glm::dvec3(0), glm::dvec3(cells));
        }
        if (glm::any(glm::lessThan(q, glm::dvec3(0))) ||
            glm::any(glm::greaterThan(q, glm::dvec3(cells))))
            return false;
        cell = glm::min(glm::ivec3(q), cells - 1);
        in = q - glm::dvec3(cell);
        return filled[cell_index(cell)];
    }
    /// The 4 x 4 x 4 nodes about a cell; at a side of the lattice the next ones, with no weight.
    [[nodiscard]] std::array<int, 64> nodes_about(glm::ivec3 cell) const
    {
        std::array<int, 64> found;
        for (int i = 0; i < 64; ++i)
            found[static_cast<std::size_t>(i)] = node_at[corner_index(
                glm::clamp(cell + glm::ivec3(i % 4, i / 4 % 4, i / 16) - 1, glm::ivec3(0), cells))];
        return found;
    }
    /// Catmull and Rom's weights of four nodes; beyond a side the parabola through the last three.
    static std::array<double, 4> weights_along(double u, int cell, int cells)
    {
        std::array<double, 4> w{0.5 * u * (u * (2 - u) - 1), 0.5 * (u * u * (3 * u - 5) + 2),
                                0.5 * u * (u * (4 - 3 * u) + 1), 0.5 * u * u * (u - 1)};
        if (cell == 0) {
            w[1] += 3 * w[0];
            w[2] -= 3 * w[0];
            w[3] += w[0];
            w[0] = 0;
        }
        if (cell == cells - 1) {
            w[2] += 3 * w[3];
            w[1] -= 3 * w[3];
            w[0] += w[3];
            w[3] = 0;
        }
        return w;
    }
    [[nodiscard]] std::array<double, 64> weights_in(glm::ivec3 cell, glm::dvec3 in) const
    {
        const auto x = weights_along(in.x, cell.x, cells.x),
                   y = weights_along(in.y, cell.y, cells.y),
                   z = weights_along(in.z, cell.z, cells.z);
        std::array<double, 64> w;
        for (std::size_t i = 0; i < 64; ++i)
            w[i] = x[i % 4] * y[i / 4 % 4] * z[i / 16];
        return w;
    }
};

/// A part of a surface that two numbers address: p = origin + u * du + v * dv, brought to the
/// sphere if there is one.
struct ReferenceWorld::Face {
    int id = 0;
    glm::dvec3 origin{0}, du{0}, dv{0}, normal{0};
    bool sphere = false;
    glm::dvec3 center{0};
    double radius = 0;

    [[nodiscard]] SurfaceHit at(glm::dvec2 uv, int surface) const
    {
        SurfaceHit hit;
        hit.surface = surface;
        hit.p = origin + uv.x * du + uv.y * dv;
        hit.normal = normal;
        if (sphere) {
            hit.normal = glm::normalize(hit.p - center);
            hit.p = center + radius * hit.normal;
        }
        hit.shading = hit.normal;
        return hit;
    }
};

struct ReferenceWorld::Lattice {
    struct FaceCell {
        bool split = false;
        bool direct = false;
        std::array<const WorldIrradiance*, 9> nodes{};
    };
    oneapi::tbb::collaborative_once_flag made;
    std::vector<MediumLattice> media;
    double error = 0;
    Store<WorldIrradiance> face_nodes;
    Store<FaceCell> face_cells;
};

ReferenceWorld::~ReferenceWorld() = default;

ReferenceWorld::ReferenceWorld(const Scene& scene, const ReferenceSurfaces& surfaces,
                               const ReferenceMedia& media, double tolerance,
                               const std::atomic<bool>* cancel)
    : surfaces_{surfaces}, media_{media}, cancel_{cancel}, radiance_{scene.world},
      tolerance_{tolerance / 2}, lattice_{std::make_unique<Lattice>()}
{
    // Next to what the suns bring, the world's light may be a little less exact where it is weak.
    glm::dvec3 all = radiance_.mean();
    for (const Light& light : scene.lights)
        if (const auto* sun = std::get_if<SunLight>(&light))
            all += glm::dvec3(sun->irradiance) / (4 * kPi);
    floor_ = 0.2 * largest(all);
    opaque_ = -std::log(0.1 * tolerance_);
    g_ = media.largest_g();
    for (double power = g_; power > tolerance / 2 && bands_ < kMostLatticeBands; power *= g_)
        ++bands_;
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
        Bounds bounds;
        if (const auto* sphere = std::get_if<SphereSurface>(&scene.surfaces[i]))
            bounds = {sphere->center - sphere->radius, sphere->center + sphere->radius};
        else if (const auto* box = std::get_if<BoxSurface>(&scene.surfaces[i]))
            bounds = {box->min, box->max};
        else if (const auto& mesh = std::get<MeshSurface>(scene.surfaces[i]); mesh.mesh != nullptr)
            for (const glm::vec3& p : mesh.mesh->positions)
                bounds.add(mesh.translate + mesh.scale * glm::dvec3(p));
        if (!bounds.empty())
            occluders_.emplace_back(static_cast<int>(i), bounds);
    }
    if (!media.empty())
        occluders_.emplace_back(-1, media.bounds());
}

std::vector<glm::dvec3> ReferenceWorld::gather(glm::dvec3 p, int bands) const
{
    const Origin from{surfaces_.outside(p), -1, glm::dvec3(0)};
    thread_local PatchQuadrature<3> quadrature;
    const auto arriving = [&](double z, double phi) -> std::array<double, 3> {
        const glm::dvec3 wi = direction(z, phi);
        const glm::dvec3 light = radiance_(wi);
        if (light == glm::dvec3(0) || surfaces_.hidden(from, wi, kInfinity))
            return {};
        const glm::dvec3 seen =
            light * glm::exp(-media_.optical_depth({from.p, wi}, kInfinity, opaque_));
        return {seen.x, seen.y, seen.z};
    };
    if (cancel_ != nullptr && *cancel_)
        throw ReferenceCancelled();
    quadrature.run(radiance_.patches(), arriving, tolerance_, tolerance_ * 4 * kPi * floor_);
    std::vector<glm::dvec3> light(static_cast<std::size_t>(bands) *
                                  static_cast<std::size_t>(bands));
    thread_local std::vector<double> harmonics;
    quadrature.for_each([&](const PatchQuadrature<3>::Sample& sample) {
        const glm::dvec3 value =
            sample.weight * glm::dvec3(sample.value[0], sample.value[1], sample.value[2]);
        if (value == glm::dvec3(0))
            return;
        spherical_harmonics(direction(sample.x, sample.y), bands, harmonics);
        for (std::size_t i = 0; i < light.size(); ++i)
            light[i] += value * harmonics[i];
    });
    return light;
}

bool ReferenceWorld::must_split(const Bounds& cell, double size, int self) const
{
    // Whatever throws a shadow must not slip between nodes: near it cells are small against it.
    constexpr double kShare = 4;
    for (const auto& [surface, bounds] : occluders_) {
        if (surface == self)
            continue;
        const glm::dvec3 extent = bounds.max - bounds.min;
        const double largest_extent = std::max({extent.x, extent.y, extent.z});
        if (size > std::max(0.5 * distance(cell, bounds), largest_extent / kShare))
            return true;
    }
    return false;
}

std::vector<ReferenceWorld::Beam> ReferenceWorld::beams() const
{
    std::vector<Beam> beams;
    std::vector<double> harmonics;
    const std::size_t count = static_cast<std::size_t>(bands_) * static_cast<std::size_t>(bands_);
    if (!radiance_.is_map()) {
        // Rows by Gauss and Legendre, apart above and below the horizon, where there often is a
        // ground; every other row turned by half a step.
        constexpr std::array<double, 6> kNode{0.0337652428984240, 0.1693953067668677,
                                              0.3806904069584016, 0.6193095930415985,
                                              0.8306046932331323, 0.9662347571015760};
        constexpr std::array<double, 6> kWeight{0.0856622461895852, 0.1803807865240693,
                                                0.2339569672863455, 0.2339569672863455,
                                                0.1803807865240693, 0.0856622461895852};
        constexpr int kColumns = 24;
        for (int row = 0; row < 12; ++row) {
            const auto i = static_cast<std::size_t>(row % 6);
            const double z = row < 6 ? -kNode[i] : kNode[i];
            for (int column = 0; column < kColumns; ++column) {
                Beam beam;
                beam.wi = direction(z, 2 * kPi * (column + 0.5 * (row % 2)) / kColumns);
                spherical_harmonics(beam.wi, bands_, harmonics);
                for (const double y : harmonics)
                    beam.light.push_back(radiance_.mean() * (2 * kPi / kColumns * kWeight[i] * y));
                beams.push_back(std::move(beam));
            }
        }
        return beams;
    }
    // A map: parts that hold little of its light each, seen from where their light is.
    constexpr int kRows = 8, kColumns = 16;
    constexpr double kMostLight = 1.0 / 192;
    const std::vector<WorldRadiance::Patch> patches = radiance_.cut(kRows, kColumns, kMostLight);
    beams.resize(patches.size());
    oneapi::tbb::parallel_for(std::size_t(0), patches.size(), [&](std::size_t i) {
        Beam& beam = beams[i];
        beam.light.resize(count);
        std::vector<double> y;
        radiance_.for_each_texel(patches[i], [&](glm::dvec3 wi, glm::dvec3 light) {
            if (light == glm::dvec3(0))
                return;
            beam.wi += largest(light) * wi;
            spherical_harmonics(wi, bands_, y);
            for (std::size_t k = 0; k < count; ++k)
                beam.light[k] += light * y[k];
        });
    });
    std::erase_if(beams, [](const Beam& beam) { return beam.wi == glm::dvec3(0); });
    for (Beam& beam : beams)
        beam.wi = glm::normalize(beam.wi);
    return beams;
}

bool ReferenceWorld::lay_out(const ReferenceMedia::Scatterer& medium, double coarse,
                             MediumLattice& lattice)
{
    constexpr double kMostCells = 6e7;
    lattice.local_from_world = medium.local_from_world;
    lattice.world_from_local = glm::inverse(medium.local_from_world);
    lattice.graded = medium.sampler == nullptr;
    const glm::dvec3 extent = medium.bounds.max - medium.bounds.min;
    glm::dvec3 cells = glm::max(glm::ceil(medium.cells / coarse), glm::dvec3(3));
    lattice.step = extent * coarse / medium.cells;
    lattice.first = medium.bounds.min;
    if (lattice.graded)
        lattice.step = extent / cells;
    else  // a cell about all for interpolation's outer nodes
        lattice.first -= lattice.step, cells += 2.0;
    if ((cells.x + 1) * (cells.y + 1) * (cells.z + 1) > kMostCells)
        return false;
    lattice.cells = glm::ivec3(cells);
    lattice.size = kInfinity;
    for (int axis = 0; axis < 3; ++axis)
        lattice.size = std::min(lattice.size,
                                lattice.step[axis] * glm::length(lattice.world_from_local[axis]));
    const auto all = [&](glm::ivec3 n) {
        return static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y) *
               static_cast<std::size_t>(n.z);
    };
    lattice.filled.assign(all(lattice.cells), lattice.graded);
    std::vector<bool> needed(all(lattice.cells + 1), lattice.graded);
    const auto for_each = [](glm::ivec3 low, glm::ivec3 high, const auto& use) {
        for (int z = low.z; z <= high.z; ++z)
            for (int y = low.y; y <= high.y; ++y)
                for (int x = low.x; x <= high.x; ++x)
                    use(glm::ivec3(x, y, z));
    };
    if (!lattice.graded)
        medium.sampler->for_each_filled([&](glm::ivec3 low, glm::ivec3 high) {
            // A voxel is seen as far as its neighbours' centres.
            const glm::dvec3 a = (glm::dvec3(low) - 1.0 - lattice.first) / lattice.step;
            const glm::dvec3 b = (glm::dvec3(high) + 1.0 - lattice.first) / lattice.step;
            for_each(glm::max(glm::ivec3(a), glm::ivec3(1)),
                     glm::min(glm::ivec3(glm::ceil(b)) - 1, lattice.cells - 2),
                     [&](glm::ivec3 cell) {
                         if (lattice.filled[lattice.cell_index(cell)])
                             return;
                         lattice.filled[lattice.cell_index(cell)] = true;
                         for_each(cell - 1, cell + 2, [&](glm::ivec3 corner) {
                             needed[lattice.corner_index(corner)] = true;
                         });
                     });
        });
    lattice.node_at.assign(needed.size(), -1);
    lattice.corner_of.clear();
    for (std::size_t i = 0; i < needed.size(); ++i)
        if (needed[i]) {
            lattice.node_at[i] = static_cast<int>(lattice.corner_of.size());
            lattice.corner_of.push_back(static_cast<int>(i));
        }
    return lattice.nodes() <= kMostNodes;
}

std::vector<glm::dvec3> ReferenceWorld::gather(glm::dvec3 p, const std::vector<Beam>& beams) const
{
    const Origin from{surfaces_.outside(p), -1, glm::dvec3(0)};
    std::vector<glm::dvec3> sum(static_cast<std::size_t>(bands_) *
                                static_cast<std::size_t>(bands_));
    for (const Beam& beam : beams) {
        if (surfaces_.hidden(from, beam.wi, kInfinity))
            continue;
        const glm::dvec3 seen =
            glm::exp(-media_.optical_depth({from.p, beam.wi}, kInfinity, opaque_));
        for (std::size_t k = 0; k < sum.size(); ++k)
            sum[k] += seen * beam.light[k];
    }
    return sum;
}

void ReferenceWorld::light_up(const std::vector<Beam>& beams, MediumLattice& lattice) const
{
    const std::size_t count = static_cast<std::size_t>(bands_) * static_cast<std::size_t>(bands_);
    lattice.harmonics = count;
    lattice.light.assign(lattice.nodes() * count, glm::vec3(0));
    oneapi::tbb::parallel_for(std::size_t(0), lattice.nodes(), [&](std::size_t node) {
        if (cancel_ != nullptr && *cancel_)
            throw ReferenceCancelled();
        const int corner = lattice.corner_of[node];
        const glm::ivec3 corners = lattice.cells + 1;
        const glm::ivec3 at(corner % corners.x, corner / corners.x % corners.y,
                            corner / corners.x / corners.y);
        const std::vector<glm::dvec3> sum = gather(lattice.place(at), beams);
        std::copy(sum.begin(), sum.end(),
                  lattice.light.begin() + static_cast<std::ptrdiff_t>(node * count));
    });
}

double ReferenceWorld::measure(const MediumLattice& lattice) const
{
    // Places spread in proportion to what they scatter out of the medium: what finds its way in
    // from all around finds it out again, so the light counts twice.
    constexpr std::size_t kPlaces = 64;
    std::vector<glm::ivec3> cells;
    std::vector<double> before{0};
    for (int z = 0; z < lattice.cells.z; ++z)
        for (int y = 0; y < lattice.cells.y; ++y)
            for (int x = 0; x < lattice.cells.x; ++x)
                if (lattice.filled[lattice.cell_index({x, y, z})])
                    cells.emplace_back(x, y, z);
    std::vector<double> weights(cells.size());
    oneapi::tbb::parallel_for(std::size_t(0), cells.size(), [&](std::size_t i) {
        const glm::dvec3 low = lattice.place(cells[i]), high = lattice.place(cells[i] + 1);
        const glm::dvec3 size = glm::abs(high - low);
        const int node = lattice.node_at[lattice.corner_index(cells[i])];
        const glm::dvec3 light(lattice.light[static_cast<std::size_t>(node) * lattice.harmonics]);
        weights[i] = size.x * size.y * size.z *
                     largest(media_.at((low + high) / 2.0).sigma_s * light * light);
    });
    for (const double weight : weights)
        before.push_back(before.back() + weight);
    if (!(before.back() > 0))
        return 0;
    std::array<double, kPlaces> squares;
    oneapi::tbb::parallel_for(std::size_t(0), kPlaces, [&](std::size_t i) {
        const double want = before.back() * (static_cast<double>(i) + 0.5) / kPlaces;
        const auto after = std::upper_bound(before.begin(), before.end() - 1, want);
        const glm::ivec3 cell = cells[static_cast<std::size_t>(after - before.begin()) - 1];
        const glm::dvec3 middle(0.5);
        const std::vector<glm::dvec3> exact =
            gather(lattice.place(glm::dvec3(cell) + middle), bands_);
        const std::array<int, 64> nodes = lattice.nodes_about(cell);
        const std::array<double, 64> weight = lattice.weights_in(cell, middle);
        glm::dvec3 off(0), whole(0);
        double fade = 1;
        for (std::size_t l = 0, k = 0; k < lattice.harmonics; ++l, fade *= g_ * g_)
            for (; k < (l + 1) * (l + 1); ++k) {
                glm::dvec3 here(0);
                for (std::size_t n = 0; n < 64; ++n)
                    here +=
                        weight[n] *
                        glm::dvec3(
                            lattice
                                .light[static_cast<std::size_t>(nodes[n]) * lattice.harmonics + k]);
                off += fade * (here - exact[k]) * (here - exact[k]);
                whole += fade * exact[k] * exact[k];
            }
        squares[i] = largest(whole) > 0 ? largest(off) / largest(whole) : 0;
    });
    double sum = 0;
    for (const double square : squares)
        sum += square / kPlaces;
    // And what the bands left out would have brought.
    return std::sqrt(sum) + std::pow(g_, bands_);
}

void ReferenceWorld::make_lattices() const
{
    const std::vector<Beam> directions = beams();
    for (const ReferenceMedia::Scatterer& medium : media_.scatterers()) {
        MediumLattice lattice;
        double coarse = 1;
        while (!lay_out(medium, coarse, lattice))
            coarse *= 1.25;
        light_up(directions, lattice);
        lattice.error = measure(lattice);
        MediumLattice finer;
        if (lattice.error > tolerance_ && lay_out(medium, coarse / 2, finer)) {
            light_up(directions, finer);
            finer.error = measure(finer);
            lattice = std::move(finer);
        }
        lattice_->error = std::max(lattice_->error, lattice.error);
        lattice_->media.push_back(std::move(lattice));
    }
    std::stable_sort(
        lattice_->media.begin(), lattice_->media.end(),
        [](const MediumLattice& a, const MediumLattice& b) { return a.size < b.size; });
}

double ReferenceWorld::error_of(double value) const
{
    return std::max(lattice_->error, tolerance_) * std::max(value, floor_);
}

struct ReferenceWorld::Towards::Memory {
    /// The light of a cell's nodes towards wo: band by band, and summed for one g.
    struct Cell {
        std::vector<glm::vec3> bands;
        double g = 0;
        std::array<glm::dvec3, 64> sums;

        void sum(double for_g)
        {
            g = for_g;
            sums.fill(glm::dvec3(0));
            double power = 1;
            for (std::size_t i = 0; i < bands.size(); power *= g)
                for (glm::dvec3& one : sums)
                    one += power * glm::dvec3(bands[i++]);
        }
    };
    std::vector<float> harmonics;
    std::vector<std::unordered_map<std::size_t, Cell>> cells;  ///< by lattice
};

ReferenceWorld::Towards::Towards(const ReferenceWorld& world, glm::dvec3 wo)
    : world_{world}, memory_{std::make_unique<Memory>()}
{
    if (world.radiance_.black())
        return;
    oneapi::tbb::collaborative_call_once(world.lattice_->made, [&] { world.make_lattices(); });
    // The phase, as a function of the way light travels, is centred on wo: of where it comes from,
    // on -wo.
    std::vector<double> harmonics;
    spherical_harmonics(-wo, world.bands_, harmonics);
    memory_->harmonics.assign(harmonics.begin(), harmonics.end());
    memory_->cells.resize(world.lattice_->media.size());
}

ReferenceWorld::Towards::~Towards() = default;

glm::dvec3 ReferenceWorld::Towards::operator()(glm::dvec3 p, double g)
{
    const auto bands = static_cast<std::size_t>(world_.bands_);
    for (std::size_t i = 0; i < memory_->cells.size(); ++i) {
        const MediumLattice& lattice = world_.lattice_->media[i];
        glm::ivec3 at;
        glm::dvec3 in;
        if (!lattice.find(p, at, in))
            continue;
        Memory::Cell& cell = memory_->cells[i][lattice.cell_index(at)];
        if (cell.bands.empty()) {
            cell.bands.resize(64 * bands);
            const std::array<int, 64> nodes = lattice.nodes_about(at);
            for (std::size_t n = 0; n < 64; ++n) {
                const glm::vec3* light =
                    &lattice.light[static_cast<std::size_t>(nodes[n]) * lattice.harmonics];
                for (std::size_t l = 0; l < bands; ++l)
                    for (std::size_t k = l * l; k < (l + 1) * (l + 1); ++k)
                        cell.bands[l * 64 + n] += light[k] * memory_->harmonics[k];
            }
            cell.sum(g);
        } else if (cell.g != g) {
            cell.sum(g);
        }
        const std::array<double, 64> weight = lattice.weights_in(at, in);
        glm::dvec3 sum(0);
        for (std::size_t n = 0; n < 64; ++n)
            sum += weight[n] * cell.sums[n];
        return glm::max(sum, glm::dvec3(0));
    }
    return glm::dvec3(0);
}

glm::dvec3 ReferenceWorld::in_scattering(glm::dvec3 p, glm::dvec3 wo, double g) const
{
    const std::vector<glm::dvec3> light = gather(p, kMostBands);
    std::vector<double> harmonics;
    spherical_harmonics(-wo, kMostBands, harmonics);
    glm::dvec3 sum(0);
    double power = 1;
    for (std::size_t l = 0, k = 0; l < kMostBands; ++l, power *= g)
        for (; k < (l + 1) * (l + 1); ++k)
            sum += power * light[k] * harmonics[k];
    return sum;
}

// ------------------------------------------------------------------------------------ surfaces

WorldIrradiance ReferenceWorld::gather_irradiance(const Origin& from, glm::dvec3 normal) const
{
    if (cancel_ != nullptr && *cancel_)
        throw ReferenceCancelled();
    const auto arriving = [&](glm::dvec3 wi, double scale) -> std::array<double, 6> {
        const glm::dvec3 light = scale * radiance_(wi);
        if (light == glm::dvec3(0) || surfaces_.hidden(from, wi, kInfinity))
            return {};
        const glm::dvec3 lit =
            light * glm::exp(-media_.optical_depth({from.p, wi}, kInfinity, opaque_));
        return {light.x, light.y, light.z, lit.x, lit.y, lit.z};
    };
    thread_local PatchQuadrature<6> quadrature;
    const double relative = tolerance_, absolute = relative * kPi * floor_;
    WorldIrradiance sum;
    if (radiance_.patches().size() > 32) {
        // A map: its own patches, which know where the light is.
        sum.error = quadrature.run(
            radiance_.patches(),
            [&](double z, double phi) {
                const glm::dvec3 wi = direction(z, phi);
                const double cosine = glm::dot(wi, normal);
                return cosine > 0 ? arriving(wi, cosine) : std::array<double, 6>{};
            },
            relative, absolute);
    } else {
        // About the normal, by the square of the sine: the cosine is in the measure.
        const glm::dvec3 helper =
            std::abs(normal.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
        const glm::dvec3 right = glm::normalize(glm::cross(helper, normal));
        const glm::dvec3 up = glm::cross(normal, right);
        std::vector<WorldRadiance::Patch> patches;
        constexpr int kRings = 2, kSectors = 8;
        for (int ring = 0; ring < kRings; ++ring)
            for (int sector = 0; sector < kSectors; ++sector)
                patches.push_back({double(ring) / kRings, double(ring + 1) / kRings,
                                   2 * kPi * sector / kSectors, 2 * kPi * (sector + 1) / kSectors});
        sum.error = quadrature.run(
            patches,
            [&](double s, double phi) {
                const double r = std::sqrt(s);
                return arriving(r * std::cos(phi) * right + r * std::sin(phi) * up +
                                    std::sqrt(1 - s) * normal,
                                0.5);
            },
            relative, absolute);
    }
    quadrature.for_each([&](const PatchQuadrature<6>::Sample& sample) {
        const auto& v = sample.value;
        sum.clear += sample.weight * glm::dvec3(v[0], v[1], v[2]);
        sum.lit += sample.weight * glm::dvec3(v[3], v[4], v[5]);
    });
    return sum;
}

WorldIrradiance ReferenceWorld::irradiance(const SurfaceHit& hit) const
{
    if (radiance_.black())
        return {};
    const Surface& surface = surfaces_.surface(hit.surface);
    if (const auto* box = std::get_if<BoxSurface>(&surface)) {
        const int axis = hit.normal.x != 0 ? 0 : (hit.normal.y != 0 ? 1 : 2);
        const bool high = hit.normal[axis] > 0;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        Face face;
        face.id = hit.surface * 6 + axis * 2 + (high ? 1 : 0);
        face.origin = box->min;
        if (high)
            face.origin[axis] = box->max[axis];
        face.du[u] = box->max[u] - box->min[u];
        face.dv[v] = box->max[v] - box->min[v];
        face.normal = hit.normal;
        return on_face(hit, face);
    }
    if (const auto* sphere = std::get_if<SphereSurface>(&surface)) {
        // The sides of a cube about the sphere.
        const glm::dvec3 n = hit.normal, a = glm::abs(n);
        const int axis = a.x >= a.y && a.x >= a.z ? 0 : (a.y >= a.z ? 1 : 2);
        const bool high = n[axis] > 0;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        Face face;
        face.id = hit.surface * 6 + axis * 2 + (high ? 1 : 0);
        face.sphere = true;
        face.center = sphere->center;
        face.radius = sphere->radius;
        face.origin = sphere->center - sphere->radius;
        if (high)
            face.origin[axis] = sphere->center[axis] + sphere->radius;
        face.du[u] = face.dv[v] = 2 * sphere->radius;
        SurfaceHit on_cube = hit;
        on_cube.p = sphere->center + n * (sphere->radius / a[axis]);
        return on_face(on_cube, face);
    }
    return gather_irradiance(surfaces_.leave(hit), hit.shading);
}

WorldIrradiance ReferenceWorld::on_face(const SurfaceHit& hit, const Face& face) const
{
    using FaceCell = Lattice::FaceCell;
    const glm::dvec3 q = hit.p - face.origin;
    const glm::dvec2 uv = glm::clamp(glm::dvec2(glm::dot(q, face.du) / glm::dot(face.du, face.du),
                                                glm::dot(q, face.dv) / glm::dot(face.dv, face.dv)),
                                     0.0, 1.0);
    const double face_size = std::max(glm::length(face.du), glm::length(face.dv));
    const auto make = [&](int level, glm::ivec2 index) {
        FaceCell cell;
        const double share = 1.0 / (1 << level);
        Bounds bounds;
        for (const int corner : {0, 1, 2, 3})
            bounds.add(face.at(glm::dvec2(index + glm::ivec2(corner & 1, corner >> 1)) * share,
                               hit.surface)
                           .p);
        const double size = face_size * share;
        if (level < kDeepest && must_split(bounds, size, hit.surface)) {
            cell.split = true;
            return cell;
        }
        const int step = 1 << (kDeepest - level);
        for (int i = 0; i < 9; ++i) {
            const glm::ivec2 at = (2 * index + glm::ivec2(i % 3, i / 3)) * step;
            cell.nodes[static_cast<std::size_t>(i)] =
                &lattice_->face_nodes.get({face.id, 0, {at, 0}}, [&] {
                    const SurfaceHit there =
                        face.at(glm::dvec2(at) / double(1 << (kDeepest + 1)), hit.surface);
                    return gather_irradiance({there.p, hit.surface, there.normal}, there.normal);
                });
        }
        double scale = kPi * floor_, worst = 0;
        for (const WorldIrradiance* n : cell.nodes)
            scale = std::max({scale, largest(n->lit), largest(n->clear)});
        for (const int i : {1, 3, 4, 5, 7}) {
            glm::dvec3 clear(0), lit(0);
            for (const int corner : {0, 2, 6, 8}) {
                const int dx = std::abs(corner % 3 - i % 3), dy = std::abs(corner / 3 - i / 3);
                const double weight = (1 - dx / 2.0) * (1 - dy / 2.0);
                clear += weight * cell.nodes[static_cast<std::size_t>(corner)]->clear;
                lit += weight * cell.nodes[static_cast<std::size_t>(corner)]->lit;
            }
            const WorldIrradiance& there = *cell.nodes[static_cast<std::size_t>(i)];
            worst = std::max({worst, largest(there.clear - clear), largest(there.lit - lit)});
        }
        if (worst > kQuadraticGain * tolerance_ * scale) {
            // A line along which two surfaces meet is never smooth: there, ask the place itself.
            constexpr double kLeast = 1.0 / 64;
            double small = face_size;
            for (const auto& [surface, other] : occluders_)
                if (surface != hit.surface) {
                    const glm::dvec3 extent = other.max - other.min;
                    small = std::min(small, std::max({extent.x, extent.y, extent.z}));
                }
            cell.direct = level == kDeepest || size < kLeast * small;
            cell.split = !cell.direct;
        }
        return cell;
    };
    for (int level = 0;; ++level) {
        const glm::ivec2 index =
            glm::min(glm::ivec2(uv * double(1 << level)), glm::ivec2((1 << level) - 1));
        const FaceCell& cell = lattice_->face_cells.get({face.id, level, {index, 0}},
                                                        [&] { return make(level, index); });
        if (cell.split)
            continue;
        if (cell.direct) {
            const SurfaceHit there = face.at(uv, hit.surface);
            return gather_irradiance({there.p, hit.surface, there.normal}, there.normal);
        }
        const glm::dvec2 at = uv * double(1 << level) - glm::dvec2(index);
        const auto wx = weights(at.x), wy = weights(at.y);
        WorldIrradiance sum;
        for (std::size_t i = 0; i < 9; ++i) {
            sum.clear += wx[i % 3] * wy[i / 3] * cell.nodes[i]->clear;
            sum.lit += wx[i % 3] * wy[i / 3] * cell.nodes[i]->lit;
            sum.error = std::max(sum.error, cell.nodes[i]->error);
        }
        sum.error += tolerance_ * std::max(largest(sum.lit), kPi * floor_);
        return sum;
    }
}

}  // namespace fumarole::study
