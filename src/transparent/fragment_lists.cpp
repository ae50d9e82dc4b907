#include "transparent/fragment_lists.h"

#include <algorithm>
#include <fmt/format.h>

namespace fumarole::transparent {

namespace {

constexpr std::uint64_t kWordBytes = 4;
constexpr std::uint64_t kFirstLayers = 2;  ///< over all pixels: room that there is from the start

/// glsl/scene/fragment_lists.glsl: fragment_words().
std::uint64_t fragment_bytes(bool half_color)
{
    return (half_color ? 5 : 7) * kWordBytes;
}

}  // namespace

FragmentLists::FragmentLists(const gl::Device& device)
    : device_{device}, readback_{device}, counter_{device, "transparent fragments counted",
                                                   kWordBytes},
      framebuffer_{device, "transparent fragments"}
{
}

void FragmentLists::make_buffer(std::uint64_t fragments)
{
    const std::uint64_t bytes = fragment_bytes(half_color_);
    const auto most = static_cast<std::uint64_t>(device_.capabilities().max_storage_bytes) / bytes;
    room_ = std::min(fragments, most);
    fragments_ = {};  // never both at once
    fragments_ = {device_, "transparent fragments", room_ * bytes};
}

std::uint64_t FragmentLists::bytes() const
{
    return static_cast<std::uint64_t>(size_.x) * static_cast<std::uint64_t>(size_.y) * kWordBytes +
           fragments_.bytes() + counter_.bytes();
}

void FragmentLists::look()
{
    const std::optional<std::uint32_t> counted = readback_.take();
    if (!counted)
        return;
    count_ = {*counted, *counted > room_ ? *counted - room_ : 0};
    wanted_ = std::max<std::uint64_t>(wanted_, *counted);
}

FragmentLists::Count FragmentLists::count()
{
    look();
    return count_;
}

void FragmentLists::begin(glm::ivec2 size, bool half_color)
{
    look();
    const auto pixels = static_cast<std::uint64_t>(size.x) * static_cast<std::uint64_t>(size.y);
    if (size != size_) {
        size_ = size;
        first_ = gl::Texture::make_2d(device_, "transparent fragment lists", size, GL_R32UI,
                                      gl::Filter::nearest);
        framebuffer_.set_empty(size);
        wanted_ = 0;
        room_ = 0;
    }
    if (half_color != half_color_) {
        half_color_ = half_color;
        room_ = 0;
    }
    const std::uint64_t needed = std::max(wanted_, kFirstLayers * pixels);
    if (room_ < needed) {
        const std::uint64_t before = room_;
        if (before == 0 || !told_)
            make_buffer(needed +
                        needed / 8);  // so that what grows slowly is not made anew each frame
        if (room_ < needed && !told_) {
            told_ = true;
            device_.log(LogLevel::warning,
                        fmt::format("{} transparent fragments are in view, and this GL holds {}: "
                                    "the farthest are not drawn; take fewer transparents or a "
                                    "smaller picture",
                                    needed, room_));
        }
    }
    constexpr std::uint32_t kNone = 0;
    first_.clear(GL_RED_INTEGER, GL_UNSIGNED_INT, &kNone);
    counter_.clear();
}

void FragmentLists::bind(GLuint image, GLuint first_buffer) const
{
    static_assert(FRAGMENTS_BUFFER == FRAGMENT_COUNT_BUFFER + 1);
    device_->BindImageTexture(image, first_.id(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
    device_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, first_buffer, counter_.id());
    device_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, first_buffer + 1, fragments_.id());
}

void FragmentLists::let_read() const
{
    // For the resolve, and for what begins the next frame's lists.
    device_->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                           GL_BUFFER_UPDATE_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

void FragmentLists::end()
{
    let_read();
    readback_.ask(counter_.id());
}

gl::Defines FragmentLists::defines() const
{
    return half_color_ ? gl::Defines{{"kHalfColor", ""}} : gl::Defines{};
}

}  // namespace fumarole::transparent
