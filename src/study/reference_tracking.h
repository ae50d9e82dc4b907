#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "study/reference_geometry.h"
#include "study/reference_media.h"
#include <fumarole/voxel_grid.h>

// Free flights through the media: tentative collisions against majorants (delta tracking; Woodcock
// et al. 1965, Novak et al. 2018, "Monte Carlo Methods for Volumetric Light Transport Simulation").
// Every medium is a Poisson process of its own majorant, so that only the medium that a collision
// belongs to is looked up, and media that overlap need no common bound.

namespace fumarole::study {

/// Independent numbers for one path: SplitMix64 (Steele, Lea and Flood 2014).
class Random {
public:
    explicit Random(std::uint64_t seed) : state_{seed} {}

    /// In [0, 1).
    double operator()()
    {
        state_ += 0x9e3779b97f4a7c15u;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30u)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27u)) * 0x94d049bb133111ebu;
        return static_cast<double>((z ^ (z >> 31u)) >> 11u) * 0x1p-53;
    }

private:
    std::uint64_t state_;
};

/// Upper bounds of a grid's trilinear field, one for each block of cells.
class BlockBounds {
public:
    using Function = std::function<double(glm::dvec3)>;

    /// @param of what is bounded, a function of the field that no channel makes smaller as it grows
    BlockBounds(const VoxelGrid& grid, const Function& of);
    /// Of the largest channel, each times its weight.
    BlockBounds(const VoxelGrid& grid, glm::dvec3 weight);

    /// A block's edge in voxels is 1 << shift(): a brick, or more where bricks would be too many.
    [[nodiscard]] int shift() const { return shift_; }
    [[nodiscard]] glm::ivec3 first() const { return first_; }
    [[nodiscard]] glm::ivec3 size() const { return size_; }
    /// @param block within size(), counted from first()
    [[nodiscard]] double at(glm::ivec3 block) const
    {
        return static_cast<double>(
            values_[static_cast<std::size_t>((block.z * size_.y + block.y) * size_.x + block.x)]);
    }
    [[nodiscard]] double largest() const { return largest_; }

private:
    void raise(glm::ivec3 first_brick, glm::ivec3 last_brick, float bound);

    int shift_ = 3;
    glm::ivec3 first_{0}, size_{0};
    double largest_ = 0;
    std::vector<float> values_;
};

/// A place where a flight may end.
struct TentativeCollision {
    double t = 0;                       ///< metres along the ray
    double majorant = 0;                ///< majorant of the medium there [1/m]
    glm::dvec3 sigma_s{0}, sigma_t{0};  ///< coefficients of the medium that collides alone [1/m]
};

/// The media of a scene, made ready to be flown through. Const members may be called from any
/// thread.
class MediaTracking {
public:
    explicit MediaTracking(const ReferenceMedia& media);

    /// The g of a scattering at p: the mean over the media there, weighted by sigma_s.
    [[nodiscard]] double g(glm::dvec3 p) const;

    /// An unbiased estimate of the transmittance, by ratio tracking where a medium's optical depth
    /// is dear. As unsure as a path is anyway, for a tenth of an exact depth's work in a grid.
    [[nodiscard]] glm::dvec3 transmittance(const Ray& ray, double range, Random& random) const;

    /// An unbiased estimate of the radiance that media emit towards a ray's origin between there
    /// and `range`, dimmed on its way. Places are spaced evenly over the emission's bound, from an
    /// offset by chance.
    /// @param passed what is let through from a distance along the ray [m] besides; none for all
    [[nodiscard]] glm::dvec3 emitted(const Ray& ray, double range, Random& random,
                                     const std::function<glm::dvec3(double)>& passed = {}) const;

private:
    friend class FreeFlight;
    using Entry = ReferenceMedia::Entry;

    /// Where collisions may be, and how densely: the rate is a bound of what is looked for.
    struct Process {
        enum class Kind { constant, height, blocks };
        Kind kind = Kind::constant;
        const Entry* entry = nullptr;
        const ReferenceMedia::Field* field = nullptr;  ///< field of the blocks
        bool blackbody = false;  ///< the field is a temperature, whose emission is looked for
        double rate = 0;         ///< 1/m; of height where its profile is 1; of blocks per bound
        double least_rate = 0;   ///< smallest rate of blocks that are not empty [1/m]
        std::size_t blocks = 0;  ///< index into blocks_
    };

    /// A process on a ray.
    struct Stream {
        const Process* process = nullptr;
        const BlockBounds* blocks = nullptr;
        double begin = 0, end = 0, t = 0;
        double rate = 0;  ///< rate at t [1/m]
        double k = 0;     ///< growth of a height profile's exponent per metre
        glm::ivec3 block{0}, step{0};
        std::array<double, 3> next{}, apart{};  ///< distances along the ray to the next of the
                                                ///< blocks' planes, and between two

        /// Goes on until so many expected collisions are passed; false if the stream ends before.
        bool advance(double collisions);
        /// Collisions expected from t on; some number above `most` if there are more.
        [[nodiscard]] double expected(double most) const;

    private:
        bool advance_by(double& left);  ///< `left` becomes what is missing at the end
    };

    /// False if the ray misses the process.
    [[nodiscard]] bool open(const Process& process, const Ray& ray, double range,
                            Stream& stream) const;

    /// Places per metre at which the emission of a box is looked for.
    [[nodiscard]] static double looks(const Entry& entry, const Ray& ray, double begin, double end);

    const ReferenceMedia& media_;
    std::vector<BlockBounds> blocks_;
    std::vector<Process> extinction_, emission_;
    bool same_g_ = true;
    double g_ = 0;
};

/// Tentative collisions of all media along a ray, in order.
class FreeFlight {
public:
    explicit FreeFlight(const MediaTracking& tracking) : tracking_{tracking} {}

    void start(const Ray& ray, double range, Random& random);

    /// Starts a flight that collides once at least, as far as that helps: in thin media most would
    /// pass, and few samples would say too little of how much the others bring.
    /// @return what the path's weight is to be multiplied with; 0 if there is nothing to collide
    /// with
    [[nodiscard]] double start_colliding(const Ray& ray, double range, Random& random);

    /// False where the range ends.
    bool next(TentativeCollision& collision, Random& random);

private:
    const MediaTracking& tracking_;
    Ray ray_;
    std::vector<MediaTracking::Stream> streams_;
    std::vector<double> expected_;
};

}  // namespace fumarole::study
