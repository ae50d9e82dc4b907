#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

// .vdb files as odd as a test wants them, and what OpenVDB itself makes of a file. The only test
// code that includes OpenVDB.

namespace fumarole::test {

struct VdbVoxel {
    glm::ivec3 index;
    glm::dvec3 value;  ///< scalar grids take .x
    bool active = true;
};

/// A filled box, inclusive; becomes tiles as large as fit.
struct VdbBox {
    glm::ivec3 min, max;
    glm::dvec3 value;
};

struct VdbGrid {
    enum class Type { float32, float64, vec3s, vec3d, boolean, int32, mask };

    std::string name = "density";
    Type type = Type::float32;
    std::string grid_class = "fog volume";  ///< or `level set`, `staggered`, `unknown`
    bool half = false;
    glm::dvec3 background{0};
    glm::dmat4 world_from_index{1.0};
    bool frustum = false;       ///< in place of world_from_index
    double sphere_radius = 0;   ///< > 0: a level set of a sphere about the origin, voxels of 1
    int shares_tree_with = -1;  ///< index of a grid before it: an instance, in OpenVDB's words

    std::vector<VdbBox> boxes;
    std::vector<VdbVoxel> voxels;  ///< set after the boxes
};

/// OpenVDB never zips grids of class `fog volume` or `level set`: it leaves them uncompressed.
enum class VdbCompression { none, zip, blosc };

void write_vdb(const std::filesystem::path& file, const std::vector<VdbGrid>& grids,
               VdbCompression compression = VdbCompression::blosc);

/// The same without offsets to its grids, as it would go down a pipe.
void write_vdb_stream(const std::filesystem::path& file, const std::vector<VdbGrid>& grids);

/// What OpenVDB's own reader finds at some indices. `address` is `density` or `density[1]`.
/// `as_fog`: after openvdb::tools::sdfToFogVolume.
std::vector<glm::dvec3> openvdb_values(const std::filesystem::path& file,
                                       const std::string& address,
                                       const std::vector<glm::ivec3>& indices, bool as_fog = false);

/// What OpenVDB's trilinear sampler finds at points of world space, in a float grid.
std::vector<double> openvdb_samples(const std::filesystem::path& file, const std::string& address,
                                    const std::vector<glm::dvec3>& p_world);

}  // namespace fumarole::test
