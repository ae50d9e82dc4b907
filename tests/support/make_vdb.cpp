#include "support/make_vdb.h"

#include <openvdb/io/File.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/LevelSetUtil.h>

#include <cstring>
#include <fstream>
#include <stdexcept>

namespace fumarole::test {

namespace {

openvdb::Coord to_coord(glm::ivec3 v)
{
    return {v.x, v.y, v.z};
}

template <class T> T to_value(glm::dvec3 v)
{
    if constexpr (std::is_same_v<T, bool>)
        return v.x != 0;
    else if constexpr (std::is_arithmetic_v<T>)
        return static_cast<T>(v.x);
    else
        return T(static_cast<typename T::ValueType>(v.x), static_cast<typename T::ValueType>(v.y),
                 static_cast<typename T::ValueType>(v.z));
}

template <class Grid> openvdb::GridBase::Ptr make(const VdbGrid& from)
{
    using T = typename Grid::ValueType;
    typename Grid::Ptr grid;
    if constexpr (std::is_same_v<Grid, openvdb::MaskGrid>)
        grid = Grid::create();
    else
        grid = Grid::create(to_value<T>(from.background));
    for (const VdbBox& box : from.boxes)
        grid->sparseFill(openvdb::CoordBBox(to_coord(box.min), to_coord(box.max)),
                         to_value<T>(box.value), true);
    auto accessor = grid->getAccessor();
    for (const VdbVoxel& voxel : from.voxels) {
        if (voxel.active)
            accessor.setValueOn(to_coord(voxel.index), to_value<T>(voxel.value));
        else
            accessor.setValueOff(to_coord(voxel.index), to_value<T>(voxel.value));
    }
    return grid;
}

openvdb::GridBase::Ptr make_any(const VdbGrid& from)
{
    openvdb::GridBase::Ptr grid;
    if (from.sphere_radius > 0) {
        grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(
            float(from.sphere_radius), openvdb::Vec3f(0), /*voxelSize=*/1.0f);
    } else {
        switch (from.type) {
        case VdbGrid::Type::float32:
            grid = make<openvdb::FloatGrid>(from);
            break;
        case VdbGrid::Type::float64:
            grid = make<openvdb::DoubleGrid>(from);
            break;
        case VdbGrid::Type::vec3s:
            grid = make<openvdb::Vec3SGrid>(from);
            break;
        case VdbGrid::Type::vec3d:
            grid = make<openvdb::Vec3DGrid>(from);
            break;
        case VdbGrid::Type::boolean:
            grid = make<openvdb::BoolGrid>(from);
            break;
        case VdbGrid::Type::int32:
            grid = make<openvdb::Int32Grid>(from);
            break;
        case VdbGrid::Type::mask:
            grid = make<openvdb::MaskGrid>(from);
            break;
        }
    }
    return grid;
}

openvdb::GridPtrVec make_all(const std::vector<VdbGrid>& from)
{
    openvdb::initialize();
    openvdb::GridPtrVec grids;
    for (const VdbGrid& one : from) {
        openvdb::GridBase::Ptr grid = one.shares_tree_with < 0
                                          ? make_any(one)
                                          : grids.at(std::size_t(one.shares_tree_with))->copyGrid();
        grid->setName(one.name);
        grid->setGridClass(openvdb::GridBase::stringToGridClass(one.grid_class));
        grid->setSaveFloatAsHalf(one.half);
        if (one.frustum) {
            grid->setTransform(openvdb::math::Transform::createFrustumTransform(
                openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(100)), /*taper=*/0.5,
                /*depth=*/10.0));
        } else {
            openvdb::Mat4d matrix;  // of row vectors, row after row
            std::memcpy(matrix.asPointer(), &one.world_from_index, sizeof(double[16]));
            grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
        }
        grids.push_back(grid);
    }
    return grids;
}

openvdb::GridBase::Ptr read(const std::filesystem::path& path, const std::string& address)
{
    openvdb::initialize();
    openvdb::io::File file(path.string());
    file.open(/*delayLoad=*/false);
    return file.readGrid(address);
}

template <class Grid>
bool values_of(const openvdb::GridBase::Ptr& base, const std::vector<glm::ivec3>& indices,
               std::vector<glm::dvec3>& values)
{
    const auto grid = openvdb::gridPtrCast<Grid>(base);
    if (!grid)
        return false;
    const auto accessor = grid->getConstAccessor();
    for (const glm::ivec3& index : indices) {
        const auto value = accessor.getValue(to_coord(index));
        if constexpr (std::is_arithmetic_v<typename Grid::ValueType>)
            values.emplace_back(double(value), 0.0, 0.0);
        else
            values.emplace_back(double(value[0]), double(value[1]), double(value[2]));
    }
    return true;
}

}  // namespace

void write_vdb(const std::filesystem::path& path, const std::vector<VdbGrid>& grids,
               VdbCompression compression)
{
    const openvdb::GridPtrVec made = make_all(grids);
    openvdb::io::File file(path.string());
    file.setCompression(openvdb::io::COMPRESS_ACTIVE_MASK |
                        (compression == VdbCompression::zip     ? openvdb::io::COMPRESS_ZIP
                         : compression == VdbCompression::blosc ? openvdb::io::COMPRESS_BLOSC
                                                                : openvdb::io::COMPRESS_NONE));
    file.write(made);
}

void write_vdb_stream(const std::filesystem::path& path, const std::vector<VdbGrid>& grids)
{
    const openvdb::GridPtrVec made = make_all(grids);
    std::ofstream out(path, std::ios::binary);
    openvdb::io::Stream(out).write(made);
}

std::vector<glm::dvec3> openvdb_values(const std::filesystem::path& file,
                                       const std::string& address,
                                       const std::vector<glm::ivec3>& indices, bool as_fog)
{
    const openvdb::GridBase::Ptr grid = read(file, address);
    if (as_fog)
        openvdb::tools::sdfToFogVolume(*openvdb::gridPtrCast<openvdb::FloatGrid>(grid));
    std::vector<glm::dvec3> values;
    if (!values_of<openvdb::FloatGrid>(grid, indices, values) &&
        !values_of<openvdb::DoubleGrid>(grid, indices, values) &&
        !values_of<openvdb::Vec3SGrid>(grid, indices, values) &&
        !values_of<openvdb::Vec3DGrid>(grid, indices, values))
        throw std::invalid_argument("grid of a type that this helper does not read");
    return values;
}

std::vector<double> openvdb_samples(const std::filesystem::path& file, const std::string& address,
                                    const std::vector<glm::dvec3>& p_world)
{
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(read(file, address));
    const openvdb::tools::GridSampler<openvdb::FloatGrid, openvdb::tools::BoxSampler> sampler(
        *grid);
    std::vector<double> samples;
    for (const glm::dvec3& p : p_world)
        samples.push_back(double(sampler.wsSample({p.x, p.y, p.z})));
    return samples;
}

}  // namespace fumarole::test
