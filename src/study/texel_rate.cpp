#include "study/texel_rate.h"

#include <fmt/format.h>

#include "gl/state_guard.h"
#include "shared/bindings.h"

namespace fumarole::study {

namespace {

constexpr int kEdge = 128, kPixels = 512, kFetches = 64;
constexpr double kLeastMs = 5;
constexpr int kMostDraws = 1 << 12;

}  // namespace

TexelRate::TexelRate(const gl::Device& device, bool computes)
    : device_{device}, computes_{computes}, timers_{device}, volume_{gl::Texture::make_3d(
                                                                 device, "texel rate",
                                                                 glm::ivec3(kEdge), GL_R16F,
                                                                 gl::Filter::linear)},
      picture_{gl::Texture::make_2d(device, "texel rate", glm::ivec2(kPixels), GL_R32F,
                                    gl::Filter::nearest)},
      framebuffer_{device, "texel rate"}, fullscreen_{device, "texel rate"},
      program_{
          device,
          computes ? std::vector<std::string>{"study/texel_rate.comp"}
                   : std::vector<std::string>{"pass/fullscreen.vert", "study/texel_rate.frag"},
          {{"kFetches", fmt::format("{}", kFetches)}, {"kTexelPixels", fmt::format("{}", kPixels)}}}
{
    const std::vector<float> ones(std::size_t{kEdge} * kEdge * kEdge, 1.0f);
    volume_.upload(GL_RED, GL_FLOAT, ones.data());
    framebuffer_.attach_color({picture_.view()});
    timers_.set_timing(gl::measuring_timing(device_));
    time(1);  // compiles
    while (draws_ < kMostDraws && time(draws_) < kLeastMs)
        draws_ *= 2;
}

double TexelRate::measure()
{
    return 1e3 * draws_ * kPixels * kPixels * kFetches / time(draws_);
}

double TexelRate::time(int draws)
{
    const gl::StateGuard guard(device_, 0, IMAGE_COUNT);
    framebuffer_.bind(glm::ivec2(kPixels));
    device_->UseProgram(program_.id());
    device_->BindVertexArray(fullscreen_.id());
    picture_.bind_image(LAYER_IMAGE, GL_WRITE_ONLY);
    volume_.bind(0);
    {
        const auto frame = timers_.frame(0);
        const auto scope = timers_.scope("texel rate");
        for (int i = 0; i < draws; ++i)
            if (computes_)
                device_->DispatchCompute(kPixels / PICTURE_GROUP, kPixels / PICTURE_GROUP, 1);
            else
                device_->DrawArrays(GL_TRIANGLES, 0, 3);
    }
    device_->Finish();
    return timers_.take()->passes.front().second;
}

}  // namespace fumarole::study
