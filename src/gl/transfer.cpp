#include "gl/transfer.h"

#include "gl/label.h"
#include <fumarole/errors.h>

namespace fumarole::gl {

TightTransfer::TightTransfer(const Device& gl, Direction direction, GLuint buffer)
    : gl_{gl}, pack_{direction == Direction::pack}
{
    gl->GetIntegerv(pack_ ? GL_PIXEL_PACK_BUFFER_BINDING : GL_PIXEL_UNPACK_BUFFER_BINDING,
                    &buffer_);
    gl->BindBuffer(target(), buffer);
    for (std::size_t i = 0; i < kNames; ++i) {
        gl->GetIntegerv(names().at(i), &values_.at(i));
        gl->PixelStorei(names().at(i), i == 0 ? 1 : 0);
    }
}

TightTransfer::~TightTransfer()
{
    for (std::size_t i = 0; i < kNames; ++i)
        gl_->PixelStorei(names().at(i), values_.at(i));
    gl_->BindBuffer(target(), static_cast<GLuint>(buffer_));
}

GLenum TightTransfer::target() const
{
    return pack_ ? GL_PIXEL_PACK_BUFFER : GL_PIXEL_UNPACK_BUFFER;
}

/// The alignment, then all that is 0 for tight rows.
const std::array<GLenum, TightTransfer::kNames>& TightTransfer::names() const
{
    static constexpr std::array<GLenum, kNames> kPack{
        GL_PACK_ALIGNMENT, GL_PACK_ROW_LENGTH,  GL_PACK_IMAGE_HEIGHT, GL_PACK_SKIP_PIXELS,
        GL_PACK_SKIP_ROWS, GL_PACK_SKIP_IMAGES, GL_PACK_SWAP_BYTES};
    static constexpr std::array<GLenum, kNames> kUnpack{
        GL_UNPACK_ALIGNMENT, GL_UNPACK_ROW_LENGTH,  GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_PIXELS,
        GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_IMAGES, GL_UNPACK_SWAP_BYTES};
    return pack_ ? kPack : kUnpack;
}

Readback::Readback(const Device& gl, TextureView texture, int layer, GLenum format)
    : device_{&gl}, count_{static_cast<std::size_t>(texture.size.x) *
                           static_cast<std::size_t>(texture.size.y) * (format == GL_RGB ? 3 : 1)}
{
    const auto bytes = static_cast<GLsizeiptr>(count_ * sizeof(float));
    constexpr GLbitfield kAccess = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    gl->CreateBuffers(1, &buffer_);
    set_label(gl, GL_BUFFER, buffer_, "texels read back");
    gl->NamedBufferStorage(buffer_, bytes, nullptr, kAccess | GL_CLIENT_STORAGE_BIT);
    mapped_ = static_cast<const float*>(gl->MapNamedBufferRange(buffer_, 0, bytes, kAccess));
    if (mapped_ == nullptr) {
        gl->DeleteBuffers(1, &buffer_);
        throw Error("OpenGL: no memory to read a shadow map or a probe back; ask for a "
                    "smaller SceneSettings::shadow_map");
    }
    {
        const TightTransfer tight(gl, TightTransfer::Direction::pack, buffer_);
        gl->GetTextureSubImage(texture.id, 0, 0, 0, layer, texture.size.x, texture.size.y, 1,
                               format, GL_FLOAT, static_cast<GLsizei>(bytes), nullptr);
    }
    fence_ = gl->FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
}

Readback::Readback(Readback&& other) noexcept
{
    swap(other);
}

Readback& Readback::operator=(Readback&& other) noexcept
{
    Readback moved(std::move(other));
    swap(moved);
    return *this;
}

void Readback::swap(Readback& other) noexcept
{
    std::swap(device_, other.device_);
    std::swap(buffer_, other.buffer_);
    std::swap(fence_, other.fence_);
    std::swap(mapped_, other.mapped_);
    std::swap(count_, other.count_);
}

void Readback::forget()
{
    if (buffer_ == 0)
        return;
    (*device_)->DeleteSync(fence_);
    (*device_)->DeleteBuffers(1, &buffer_);  // unmaps it
}

bool Readback::poll(GLuint64 timeout_ns)
{
    if (fence_ == nullptr)
        return true;
    // Flushes the commands before it, without which it might never come.
    const GLenum state = (*device_)->ClientWaitSync(fence_, GL_SYNC_FLUSH_COMMANDS_BIT, timeout_ns);
    if (state == GL_TIMEOUT_EXPIRED)
        return false;
    (*device_)->DeleteSync(fence_);
    fence_ = nullptr;
    return true;
}

bool Readback::ready()
{
    return poll(0);
}

void Readback::wait()
{
    constexpr GLuint64 kSecond = 1'000'000'000;
    while (!poll(kSecond)) {
    }
}

}  // namespace fumarole::gl
