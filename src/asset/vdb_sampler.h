#pragma once

#include <array>
#include <filesystem>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include <fumarole/voxel_grid.h>

namespace fumarole::asset {

/// A grid as OpenVDB samples it: its tree, its accessors, its trilinear stencil. Holds the very
/// values of a VoxelGrid, that is of the file under load_grid's rules (level sets made into fog,
/// what is not finite or negative made 0). Const members may be called from any thread.
class VdbSampler {
public:
    explicit VdbSampler(const VoxelGrid& grid);
    ~VdbSampler();
    VdbSampler(VdbSampler&&) noexcept;
    VdbSampler& operator=(VdbSampler&&) noexcept;

    /// Opens file and grid as load_grid does. @throws Error as it does.
    static VdbSampler open(const std::filesystem::path& file, const std::string& name);

    [[nodiscard]] bool empty() const;

    /// openvdb::tools::BoxSampler at a point of index space. A scalar grid answers in all three.
    [[nodiscard]] glm::dvec3 sample(glm::dvec3 p_index) const;

    /// The same in double precision throughout and several times as fast: what `spans` and `column`
    /// see at a point.
    [[nodiscard]] glm::dvec3 value(glm::dvec3 p_index) const;

    /// What a ray meets in one cell between eight voxel centres. There the trilinear field is a
    /// cubic polynomial of the ray's parameter: field(t) = sum over k of c[k] * (t - begin)^k.
    struct Span {
        double begin = 0, end = 0;
        std::array<glm::dvec3, 4> c{};
    };

    /// Appends the spans of origin + t * direction (index space), t in [begin, end], in order,
    /// leaving out what is known to be empty. Stops once the field's integral, over t, is above
    /// `most` in every channel.
    void spans(glm::dvec3 origin, glm::dvec3 direction, double begin, double end, double most,
               std::vector<Span>& out) const;

    /// The field's integral over t in [begin, end], exact to rounding; stops above `most` as spans.
    [[nodiscard]] glm::dvec3 column(glm::dvec3 origin, glm::dvec3 direction, double begin,
                                    double end, double most) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace fumarole::asset
