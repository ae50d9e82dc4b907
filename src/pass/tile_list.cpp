#include "pass/tile_list.h"

#include "shared/bindings.h"
#include "shared/tile_list.h"

namespace fumarole::pass {

void TileList::fill(const Toolbox& tools, const gl::Texture& tiles, const gl::Defines& variant)
{
    const gl::Device& gl = tools.device;
    const glm::uvec2 count(tiles.size());
    const std::size_t bytes =
        sizeof(shared::TileListHead) + sizeof(std::uint32_t) * TILE_CLASSES * count.x * count.y;
    if (buffer_.bytes() != bytes)
        buffer_ = {gl, "tile list", bytes};
    shared::TileListHead head{};
    head.groups_x = TILE_ROW;
    head.groups_z = 1;
    buffer_.write(&head, sizeof(head));
    tiles.bind(STEP_TILES_UNIT);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, TILE_LIST_BUFFER, buffer_.id());
    gl->UseProgram(tools.programs.get({"pass/list_tiles.comp"}, variant).id());
    constexpr unsigned kEdge = 8;
    const glm::uvec2 groups = (count + (kEdge - 1)) / kEdge;
    gl->DispatchCompute(groups.x, groups.y, 1);
}

void TileList::let_read(const Toolbox& tools)
{
    tools.device->MemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
}

void TileList::dispatch(const Toolbox& tools) const
{
    const gl::Device& gl = tools.device;
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, TILE_LIST_BUFFER, buffer_.id());
    gl->BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, buffer_.id());
    gl->DispatchComputeIndirect(0);
}

}  // namespace fumarole::pass
