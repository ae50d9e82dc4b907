#include "support/make_nvdb.h"

// Both codecs, which NanoVDB leaves out unless it is told.
#define NANOVDB_USE_ZIP
#define NANOVDB_USE_BLOSC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wall"
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/openvdb.h>
#pragma GCC diagnostic pop

#include <stdexcept>

namespace fumarole::test {

namespace {

nanovdb::GridHandle<> convert(const openvdb::GridBase::Ptr& base, NanoCodes codes,
                              nanovdb::ChecksumMode checksum)
{
    constexpr auto kStats = nanovdb::StatsMode::Default;
    const auto floats = openvdb::gridPtrCast<openvdb::FloatGrid>(base);
    if (floats && codes != NanoCodes::plain) {
        using nanovdb::HostBuffer;
        using openvdb::FloatTree;
        switch (codes) {
        case NanoCodes::fp4:
            return nanovdb::openToNanoVDB<HostBuffer, FloatTree, nanovdb::Fp4>(*floats, kStats,
                                                                               checksum, 0);
        case NanoCodes::fp8:
            return nanovdb::openToNanoVDB<HostBuffer, FloatTree, nanovdb::Fp8>(*floats, kStats,
                                                                               checksum, 0);
        case NanoCodes::fp16:
            return nanovdb::openToNanoVDB<HostBuffer, FloatTree, nanovdb::Fp16>(*floats, kStats,
                                                                                checksum, 0);
        default: {
            nanovdb::OpenToNanoVDB<float, nanovdb::FpN, nanovdb::AbsDiff> convert;
            convert.oracle() = nanovdb::AbsDiff(0.01f);
            return convert(*floats, kStats, checksum, 0);
        }
        }
    }
    return nanovdb::openToNanoVDB(base, kStats, checksum, 0);
}

template <class Codes>
std::vector<double> values_of(const nanovdb::GridHandle<>& handle,
                              const std::vector<glm::ivec3>& indices)
{
    const auto* grid = handle.grid<Codes>();
    if (grid == nullptr)
        throw std::invalid_argument("the grid has other codes");
    const auto accessor = grid->getAccessor();
    std::vector<double> values;
    for (const glm::ivec3& i : indices)
        values.push_back(double(accessor.getValue(nanovdb::Coord(i.x, i.y, i.z))));
    return values;
}

}  // namespace

void convert_to_nvdb(const std::filesystem::path& vdb, const std::filesystem::path& nvdb,
                     NanoCodes codes, VdbCompression compression, NanoChecksum checksum)
{
    openvdb::initialize();
    openvdb::io::File file(vdb.string());
    file.open(/*delayLoad=*/false);
    const openvdb::GridPtrVecPtr grids = file.getGrids();
    std::vector<nanovdb::GridHandle<>> handles;
    for (const openvdb::GridBase::Ptr& grid : *grids)
        handles.push_back(convert(grid, codes,
                                  checksum == NanoChecksum::none   ? nanovdb::ChecksumMode::Disable
                                  : checksum == NanoChecksum::head ? nanovdb::ChecksumMode::Partial
                                                                   : nanovdb::ChecksumMode::Full));
    nanovdb::io::writeGrids(nvdb.string(), handles,
                            compression == VdbCompression::zip     ? nanovdb::io::Codec::ZIP
                            : compression == VdbCompression::blosc ? nanovdb::io::Codec::BLOSC
                                                                   : nanovdb::io::Codec::NONE);
}

std::vector<double> nanovdb_values(const std::filesystem::path& nvdb, NanoCodes codes,
                                   const std::vector<glm::ivec3>& indices)
{
    const auto handle = nanovdb::io::readGrid(nvdb.string());
    switch (codes) {
    case NanoCodes::plain:
        return values_of<float>(handle, indices);
    case NanoCodes::fp4:
        return values_of<nanovdb::Fp4>(handle, indices);
    case NanoCodes::fp8:
        return values_of<nanovdb::Fp8>(handle, indices);
    case NanoCodes::fp16:
        return values_of<nanovdb::Fp16>(handle, indices);
    case NanoCodes::fpn:
        return values_of<nanovdb::FpN>(handle, indices);
    }
    return {};
}

}  // namespace fumarole::test
