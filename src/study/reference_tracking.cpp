#include "study/reference_tracking.h"

#include <algorithm>
#include <cmath>

#include "study/reference_quadrature.h"

namespace fumarole::study {

namespace {

constexpr int kBrickDim = VoxelGrid::kBrickDim;

}  // namespace

// ------------------------------------------------------------------------------------- bounds

BlockBounds::BlockBounds(const VoxelGrid& grid, glm::dvec3 weight)
    : BlockBounds(grid, [weight](glm::dvec3 value) { return study::largest(weight * value); })
{
}

BlockBounds::BlockBounds(const VoxelGrid& grid, const Function& of)
{
    if (grid.empty())
        return;
    // A table over the whole box is walked fastest; 8 MB of it are enough for 1000^3 voxels.
    constexpr double kMostBlocks = 1 << 21;
    const glm::ivec3 low = grid.index_min - 1, high = grid.index_max;
    for (;; ++shift_) {
        first_ = low >> shift_;
        size_ = (high >> shift_) - first_ + 1;
        if (glm::dvec3(size_).x * size_.y * size_.z <= kMostBlocks)
            break;
    }
    values_.resize(static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) *
                   static_cast<std::size_t>(size_.z));
    const auto bound = [&](const glm::dvec3& value) {
        // Rounded up: a bound in single precision must not fall below the field.
        const auto most = static_cast<float>(of(value));
        return most > 0 ? std::nextafter(most, std::numeric_limits<float>::infinity()) : 0.0f;
    };
    for (const VoxelTile& tile : grid.tiles)
        raise(
            tile.brick_min - 1, tile.brick_max,
            bound(grid.channels == 1 ? glm::dvec3(double(tile.value.x)) : glm::dvec3(tile.value)));
    for (std::size_t b = 0; b < grid.bricks.size(); ++b) {
        // A cell reaches to the first voxels of the bricks after it, so a brick's first voxels
        // bound the bricks before it too: one largest value for each set of axes.
        std::array<glm::vec3, 8> most{};
        const float* value = grid.values.data() +
                             b * VoxelGrid::kBrickVoxels * static_cast<std::size_t>(grid.channels);
        for (int z = 0; z < kBrickDim; ++z)
            for (int y = 0; y < kBrickDim; ++y)
                for (int x = 0; x < kBrickDim; ++x) {
                    const glm::vec3 v = grid.channels == 1
                                            ? glm::vec3(value[0])
                                            : glm::vec3(value[0], value[1], value[2]);
                    value += grid.channels;
                    most[0] = glm::max(most[0], v);
                    if (x != 0 && y != 0 && z != 0)
                        continue;
                    for (int i = 1; i < 8; ++i)
                        if (((i & 1) == 0 || x == 0) && ((i & 2) == 0 || y == 0) &&
                            ((i & 4) == 0 || z == 0))
                            most[static_cast<std::size_t>(i)] =
                                glm::max(most[static_cast<std::size_t>(i)], v);
                }
        for (int i = 0; i < 8; ++i) {
            const glm::vec3 v = most[static_cast<std::size_t>(i)];
            if (v == glm::vec3(0))
                continue;
            const glm::ivec3 brick = grid.bricks[b] - glm::ivec3(i & 1, i >> 1 & 1, i >> 2);
            raise(brick, brick, bound(glm::dvec3(v)));
        }
    }
    for (const float value : values_)
        largest_ = std::max(largest_, static_cast<double>(value));
}

void BlockBounds::raise(glm::ivec3 first_brick, glm::ivec3 last_brick, float bound)
{
    const int more = shift_ - 3;
    const glm::ivec3 low = glm::max((first_brick >> more) - first_, glm::ivec3(0));
    const glm::ivec3 high = glm::min((last_brick >> more) - first_, size_ - 1);
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x) {
                float& value = values_[static_cast<std::size_t>((z * size_.y + y) * size_.x + x)];
                value = std::max(value, bound);
            }
}

// -------------------------------------------------------------------------------------- streams

MediaTracking::MediaTracking(const ReferenceMedia& media) : media_{media}
{
    bool first = true;
    for (const Entry& entry : media.entries_) {
        if (entry.sigma_s != glm::dvec3(0)) {
            same_g_ = same_g_ && (first || entry.g == g_);
            g_ = entry.g;
            first = false;
        }
        const auto* height = std::get_if<ExpHeightProfile>(&entry.profile);
        if (entry.dims()) {
            Process process;
            process.entry = &entry;
            process.rate = largest(entry.sigma_t);
            if (entry.density) {
                process.kind = Process::Kind::blocks;
                process.field = &*entry.density;
                process.rate = 1;
                process.blocks = blocks_.size();
                blocks_.emplace_back(*entry.density->grid, entry.sigma_t);
            } else if (height != nullptr) {
                process.kind = Process::Kind::height;
            }
            extinction_.push_back(process);
        }
        const auto add_glow = [&](const ReferenceMedia::Field& field, auto bounded) {
            Process process;
            process.entry = &entry;
            process.kind = Process::Kind::blocks;
            process.field = &field;
            process.blocks = blocks_.size();
            const BlockBounds& blocks = blocks_.emplace_back(*field.grid, bounded);
            // A flame is small in its grid, and bright at its core.
            process.rate = 0.5 / (field.voxel * blocks.largest());
            process.least_rate = 0.05 / field.voxel;
            process.blackbody = entry.temperature && &field == &*entry.temperature;
            emission_.push_back(process);
        };
        if (entry.emission_field) {
            add_glow(*entry.emission_field, glm::dvec3(1));
        } else if (entry.emission != glm::dvec3(0)) {
            Process process;
            process.entry = &entry;
            emission_.push_back(process);
        }
        if (entry.temperature)
            add_glow(*entry.temperature,
                     [&entry](glm::dvec3 value) { return largest(entry.emission_at(value.x)); });
    }
}

double MediaTracking::g(glm::dvec3 p) const
{
    return same_g_ ? g_ : media_.at(p).g;
}

bool MediaTracking::open(const Process& process, const Ray& ray, double range, Stream& stream) const
{
    const Entry& entry = *process.entry;
    Ray in = ray;  // of a grid in index space, where its bounds are along the axes; t stays metres
    if (process.field != nullptr) {
        const glm::dmat4& to_index = process.field->index_from_world;
        in.origin = glm::dvec3(to_index * glm::dvec4(ray.origin, 1));
        in.direction = glm::dvec3(to_index * glm::dvec4(ray.direction, 0));
    }
    const glm::dvec2 inside =
        box_range(in, process.field != nullptr ? process.field->index_bounds : entry.bounds);
    stream.process = &process;
    stream.t = std::max(inside.x, 0.0);
    stream.end = std::min(inside.y, range);
    if (!(stream.t < stream.end))
        return false;
    stream.rate = process.rate;
    if (process.kind == Process::Kind::height) {
        const auto& height = std::get<ExpHeightProfile>(entry.profile);
        stream.k = -ray.direction.z / height.scale_height;
        stream.rate =
            process.rate * std::exp((height.z0 - ray.at(stream.t).z) / height.scale_height);
    } else if (process.kind == Process::Kind::blocks) {
        const BlockBounds& blocks = blocks_[process.blocks];
        stream.blocks = &blocks;
        const glm::dvec3 o = in.origin, d = in.direction;
        const double edge = std::ldexp(1.0, blocks.shift());
        const glm::dvec3 at = (o + d * stream.t) / edge;
        // The bounds' box is the table's: what rounding leaves outside is put back in.
        stream.block = glm::clamp(glm::ivec3(glm::floor(at)) - blocks.first(), glm::ivec3(0),
                                  blocks.size() - 1);
        for (int axis = 0; axis < 3; ++axis) {
            const auto i = static_cast<std::size_t>(axis);
            stream.step[axis] = d[axis] > 0 ? 1 : -1;
            const int plane = stream.block[axis] + blocks.first()[axis] + (d[axis] > 0 ? 1 : 0);
            stream.next[i] = d[axis] == 0 ? kInfinity : (plane * edge - o[axis]) / d[axis];
            stream.apart[i] = d[axis] == 0 ? 0 : edge / std::abs(d[axis]);
        }
    }
    return true;
}

bool MediaTracking::Stream::advance(double collisions)
{
    double left = collisions;
    return advance_by(left);
}

bool MediaTracking::Stream::advance_by(double& left)
{
    if (process->kind == Process::Kind::constant) {
        t += left / rate;
        return t < end;
    }
    if (process->kind == Process::Kind::height) {
        // The rate's integral over s metres is rate (exp(k s) - 1) / k.
        const double x = left / rate, y = k * x;
        const double s = std::abs(y) < 1e-9 ? x * (1 - y / 2) : std::log1p(y) / k;
        if (!(y > -1) || !(t + s < end))
            return false;
        t += s;
        rate *= 1 + y;
        return true;
    }
    for (;;) {
        const std::size_t axis =
            next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
        const double exit = std::min(next[axis], end), bound = blocks->at(block);
        if (bound > 0) {
            rate = std::max(bound * process->rate, process->least_rate);
            const double here = left / rate;
            if (t + here < exit) {
                t += here;
                return true;
            }
            left -= std::max(0.0, exit - t) * rate;
            left = std::max(left, 0.0);
        }
        if (!(next[axis] < end))
            return false;
        t = std::max(t, exit);
        const int a = static_cast<int>(axis);
        block[a] += step[a];
        if (block[a] < 0 || block[a] >= blocks->size()[a])
            return false;
        next[axis] += apart[axis];
    }
}

glm::dvec3 MediaTracking::transmittance(const Ray& ray, double range, Random& random) const
{
    glm::dvec3 left(1);
    for (const Process& process : extinction_) {
        const Entry& entry = *process.entry;
        if (process.kind != Process::Kind::blocks &&
            !std::holds_alternative<NoiseProfile>(entry.profile)) {
            left *= glm::exp(-media_.depth_of(entry, ray, range));
            continue;
        }
        Stream stream;
        if (!open(process, ray, range, stream))
            continue;
        // Below this the way goes on with the chance that light has: most lights are asked for in
        // vain from deep in a cloud.
        constexpr double kFaint = 0.2;
        while (stream.advance(-std::log1p(-random()))) {
            const glm::dvec3 p = ray.at(stream.t);
            const glm::dvec3 value =
                process.field != nullptr ? process.field->value(p) : media_.profile_at(entry, p);
            const glm::dvec3 through = 1.0 - entry.sigma_t * value / stream.rate;
            left *= through;
            if (study::largest(left) < kFaint) {
                const double survival = study::largest(through);
                if (random() >= survival)
                    return glm::dvec3(0);
                left /= survival;
            }
        }
    }
    return left;
}

double MediaTracking::Stream::expected(double most) const
{
    if (process->kind == Process::Kind::constant)
        return rate * (end - t);
    if (process->kind == Process::Kind::height) {
        const double y = k * (end - t);
        return rate * (end - t) * (std::abs(y) < 1e-9 ? 1 + y / 2 : std::expm1(y) / y);
    }
    Stream rest = *this;
    double sum = 0;
    for (constexpr double kStride = 0.25; sum <= most; sum += kStride) {
        double left = kStride;
        if (!rest.advance_by(left))
            return sum + kStride - left;
    }
    return sum;
}

double MediaTracking::looks(const Entry& entry, const Ray& ray, double begin, double end)
{
    // So many over a way through a medium are about as dear as the ray's other work, and leave less
    // noise than the ray's direction does; on a long way nearly all comes from the first of it.
    constexpr double kLooks = 8, kLooksPerDepth = 2;
    double most = 1;
    if (const auto* height = std::get_if<ExpHeightProfile>(&entry.profile)) {
        const double z = std::min(ray.at(begin).z, ray.at(end).z);
        most = std::exp((height->z0 - z) / height->scale_height);
    }
    return std::max(kLooks / (end - begin), kLooksPerDepth * most * largest(entry.sigma_t));
}

glm::dvec3 MediaTracking::emitted(const Ray& ray, double range, Random& random,
                                  const std::function<glm::dvec3(double)>& passed) const
{
    glm::dvec3 sum(0);
    for (const Process& process : emission_) {
        Stream stream;
        if (!open(process, ray, range, stream))
            continue;
        const Entry& entry = *process.entry;
        if (process.field == nullptr)
            stream.rate = looks(entry, ray, stream.t, stream.end);
        glm::dvec3 tau(0);
        double before = 0;
        for (double left = random(); stream.advance(left); left = 1) {
            const glm::dvec3 p = ray.at(stream.t);
            const glm::dvec3 field =
                process.field != nullptr ? process.field->value(p) : media_.profile_at(entry, p);
            const glm::dvec3 value =
                process.blackbody ? entry.emission_at(field.x) : entry.emission * field;
            if (value == glm::dvec3(0))
                continue;
            tau += media_.optical_depth({ray.at(before), ray.direction}, stream.t - before);
            before = stream.t;
            if (std::min({tau.x, tau.y, tau.z}) > ReferenceMedia::kOpaque)
                break;
            const glm::dvec3 arriving = value * glm::exp(-tau) / stream.rate;
            sum += passed ? arriving * passed(stream.t) : arriving;
        }
    }
    return sum;
}

// --------------------------------------------------------------------------------------- flights

void FreeFlight::start(const Ray& ray, double range, Random& random)
{
    ray_ = ray;
    streams_.clear();
    for (const MediaTracking::Process& process : tracking_.extinction_) {
        MediaTracking::Stream stream;
        if (tracking_.open(process, ray, range, stream) && stream.advance(-std::log1p(-random())))
            streams_.push_back(stream);
    }
}

double FreeFlight::start_colliding(const Ray& ray, double range, Random& random)
{
    // Beyond so many expected collisions nearly all flights collide by themselves.
    constexpr double kMany = 2;
    ray_ = ray;
    streams_.clear();
    expected_.clear();
    double all = 0;
    for (const MediaTracking::Process& process : tracking_.extinction_) {
        MediaTracking::Stream stream;
        if (!tracking_.open(process, ray, range, stream))
            continue;
        expected_.push_back(stream.expected(kMany));
        all += expected_.back();
        if (all > kMany) {
            start(ray, range, random);
            return 1;
        }
        streams_.push_back(stream);
    }
    // One stream after the other: whether it has a collision, given that it or a later one has.
    // Once one has, the others are free.
    const double weight = -std::expm1(-all);
    bool sure = false;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < streams_.size(); ++i) {
        MediaTracking::Stream& stream = streams_[i];
        double share = 1;  // of the distribution of the first collision that is drawn from
        if (!sure) {
            share = -std::expm1(-expected_[i]);
            sure = random() * -std::expm1(-all) < share;
            all -= expected_[i];
            if (!sure)
                continue;
        }
        if (stream.advance(-std::log1p(-random() * share)))
            streams_[kept++] = stream;
    }
    streams_.resize(kept);
    return kept > 0 ? weight : 0;
}

bool FreeFlight::next(TentativeCollision& collision, Random& random)
{
    if (streams_.empty())
        return false;
    auto nearest = streams_.begin();
    for (auto other = nearest + 1; other < streams_.end(); ++other)
        if (other->t < nearest->t)
            nearest = other;
    const MediaTracking::Process& process = *nearest->process;
    const ReferenceMedia::Entry& entry = *process.entry;
    const glm::dvec3 p = ray_.at(nearest->t);
    const glm::dvec3 value =
        process.field != nullptr ? process.field->value(p) : tracking_.media_.profile_at(entry, p);
    collision.t = nearest->t;
    collision.majorant = nearest->rate;
    collision.sigma_t = entry.sigma_t * value;
    collision.sigma_s = entry.sigma_s * value * (entry.tint ? entry.tint->value(p) : glm::dvec3(1));
    if (!nearest->advance(-std::log1p(-random()))) {
        *nearest = streams_.back();
        streams_.pop_back();
    }
    return true;
}

}  // namespace fumarole::study
