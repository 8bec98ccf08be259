#include "animation.hpp"

#include <fmt/format.h>
#include <gif_lib.h>
#include <webp/encode.h>
#include <webp/mux.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <utility>

#include "base/plain_file.hpp"
#include "palette.hpp"
#include "unfinished.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw UserError(fmt::format("{}: the animation cannot be written: {}", file.string(), what));
}

void begin(const fs::path& file, Unfinished& unfinished) {
  if (!std::ofstream(file)) fail(file, "is the folder there?");
  unfinished.begin(file);
}

class WebpWriter : public AnimationWriter {
 public:
  WebpWriter(fs::path file, double rate) : file_(std::move(file)), rate_(rate) { begin(file_, unfinished_); }
  ~WebpWriter() override { WebPAnimEncoderDelete(encoder_); }
  WebpWriter(const WebpWriter&) = delete;
  WebpWriter& operator=(const WebpWriter&) = delete;

  void add(const Image& frame) override {
    if (!encoder_) {
      WebPAnimEncoderOptions options;
      WebPAnimEncoderOptionsInit(&options);
      encoder_ = WebPAnimEncoderNew(frame.width(), frame.height(), &options);
      if (!encoder_) fail(file_, "WebP does not take pictures of this size (at most 16383 pixels)");
    }
    WebPConfig config;
    WebPPicture picture;
    if (!WebPConfigPreset(&config, WEBP_PRESET_DRAWING, 88.0F) || !WebPPictureInit(&picture))
      fail(file_, "WebP has another version");
    config.method = 3;
    picture.use_argb = 1;
    picture.width = frame.width();
    picture.height = frame.height();
    const bool done = WebPPictureImportRGB(&picture, frame.at(0, 0), 3 * frame.width()) &&
                      WebPAnimEncoderAdd(encoder_, &picture, time(), &config);
    WebPPictureFree(&picture);
    if (!done) fail(file_, WebPAnimEncoderGetError(encoder_));
    ++frames_;
  }

  void finish() override {
    WebPData data;
    WebPDataInit(&data);
    if (!encoder_ || !WebPAnimEncoderAdd(encoder_, nullptr, time(), nullptr) ||
        !WebPAnimEncoderAssemble(encoder_, &data))
      fail(file_, encoder_ ? WebPAnimEncoderGetError(encoder_) : "it has no frames");
    std::ofstream out(file_, std::ios::binary);
    out.write(reinterpret_cast<const char*>(data.bytes), static_cast<std::streamsize>(data.size)).flush();
    WebPDataClear(&data);
    if (!out) fail(file_, "is there room on the disk?");
    unfinished_.finish();
  }

 private:
  [[nodiscard]] int time() const { return static_cast<int>(std::lround(1000.0 * frames_ / rate_)); }
  fs::path file_;
  Unfinished unfinished_;
  double rate_;
  int frames_ = 0;
  WebPAnimEncoder* encoder_ = nullptr;
};

class GifWriter : public AnimationWriter {
 public:
  GifWriter(fs::path file, double rate) : file_(std::move(file)), rate_(rate) {
    int error = 0;
    begin(file_, unfinished_);  // the library would make a file that nobody else can read
    gif_ = EGifOpenFileName(file_.c_str(), false, &error);
    if (!gif_) fail(file_, GifErrorString(error));
  }
  ~GifWriter() override {
    if (gif_) (void)EGifCloseFile(gif_, nullptr);
  }
  GifWriter(const GifWriter&) = delete;
  GifWriter& operator=(const GifWriter&) = delete;

  void add(const Image& frame) override {
    if (frames_ == 0) describe(frame);
    const Reduced reduced = reduce(frame);
    int size = 2;
    while (size < static_cast<int>(reduced.palette.size())) size *= 2;
    std::vector<GifColorType> colours(static_cast<std::size_t>(size));
    for (std::size_t i = 0; i < reduced.palette.size(); ++i)
      colours[i] = {reduced.palette[i][0], reduced.palette[i][1], reduced.palette[i][2]};
    ColorMapObject* map = GifMakeMapObject(size, colours.data());
    GraphicsControlBlock control{};
    control.DisposalMode = DISPOSE_DO_NOT;
    // The format counts hundredths of a second: frames end where they should, give or take half of one.
    control.DelayTime = std::max(
        2, static_cast<int>(std::lround(100.0 * (frames_ + 1) / rate_) - std::lround(100.0 * frames_ / rate_)));
    control.TransparentColor = NO_TRANSPARENT_COLOR;
    std::array<GifByteType, 4> extension{};
    const auto length = EGifGCBToExtension(&control, extension.data());
    bool done = map &&
                EGifPutExtension(gif_, GRAPHICS_EXT_FUNC_CODE, static_cast<int>(length), extension.data()) == GIF_OK &&
                EGifPutImageDesc(gif_, 0, 0, frame.width(), frame.height(), false, map) == GIF_OK;
    std::vector<std::uint8_t> row(static_cast<std::size_t>(frame.width()));
    for (int j = 0; j < frame.height() && done; ++j) {
      std::copy_n(reduced.pixels.begin() + static_cast<std::ptrdiff_t>(j) * frame.width(), frame.width(), row.begin());
      done = EGifPutLine(gif_, row.data(), frame.width()) == GIF_OK;
    }
    GifFreeMapObject(map);
    if (!done) fail(file_, GifErrorString(gif_->Error));
    ++frames_;
  }

  void finish() override {
    int error = 0;
    if (frames_ == 0) fail(file_, "it has no frames");
    if (EGifCloseFile(std::exchange(gif_, nullptr), &error) != GIF_OK) fail(file_, GifErrorString(error));
    unfinished_.finish();
  }

 private:
  void describe(const Image& frame) {
    EGifSetGifVersion(gif_, true);
    // Repeats for ever.
    const std::array<GifByteType, 3> loop{1, 0, 0};
    if (EGifPutScreenDesc(gif_, frame.width(), frame.height(), 8, 0, nullptr) != GIF_OK ||
        EGifPutExtensionLeader(gif_, APPLICATION_EXT_FUNC_CODE) != GIF_OK ||
        EGifPutExtensionBlock(gif_, 11, "NETSCAPE2.0") != GIF_OK ||
        EGifPutExtensionBlock(gif_, 3, loop.data()) != GIF_OK || EGifPutExtensionTrailer(gif_) != GIF_OK)
      fail(file_, GifErrorString(gif_->Error));
  }
  fs::path file_;
  Unfinished unfinished_;
  double rate_;
  int frames_ = 0;
  GifFileType* gif_ = nullptr;
};

/// While it lives, writing to a pipe that nobody reads any more is an error that is returned, not the end of the program.
class BrokenPipesReturn {
 public:
  BrokenPipesReturn() : before_(std::signal(SIGPIPE, SIG_IGN)) {}
  ~BrokenPipesReturn() { (void)std::signal(SIGPIPE, before_); }
  BrokenPipesReturn(const BrokenPipesReturn&) = delete;
  BrokenPipesReturn& operator=(const BrokenPipesReturn&) = delete;

 private:
  void (*before_)(int);
};

/// Raw pictures through a pipe into ffmpeg.
class Mp4Writer : public AnimationWriter {
 public:
  Mp4Writer(fs::path file, double rate) : file_(std::move(file)), rate_(rate) {
    if (std::system("command -v ffmpeg >/dev/null 2>&1") != 0)
      fail(file_, "MP4 needs the program ffmpeg, which is not there; install it, or take the ending .webp or .gif");
    begin(file_, unfinished_);
  }
  ~Mp4Writer() override {
    if (pipe_) (void)pclose(pipe_);
  }
  Mp4Writer(const Mp4Writer&) = delete;
  Mp4Writer& operator=(const Mp4Writer&) = delete;

  void add(const Image& frame) override {
    if (!pipe_) start(frame);
    const std::size_t size = 3 * static_cast<std::size_t>(frame.width()) * static_cast<std::size_t>(frame.height());
    if (std::fwrite(frame.at(0, 0), 1, size, pipe_) != size)
      fail(file_, "ffmpeg has ended early; is there room on the disk?");
  }
  void finish() override {
    if (!pipe_ || pclose(std::exchange(pipe_, nullptr)) != 0) fail(file_, "ffmpeg reports an error");
    unfinished_.finish();
  }

 private:
  void start(const Image& frame) {
    std::string name;
    for (const char c : fs::absolute(file_).string()) name += c == '\'' ? std::string("'\\''") : std::string(1, c);
    // On a full disk ffmpeg complains, but ends with code 0.
    const std::string command = fmt::format(
        "said=$(ffmpeg -loglevel error -y -f rawvideo -pix_fmt rgb24 -s {}x{} -r {} -i - -vf "
        "'pad=ceil(iw/2)*2:ceil(ih/2)*2' -pix_fmt yuv420p -crf 18 '{}' 2>&1) && test -z \"$said\" || "
        "{{ echo \"$said\" >&2; exit 1; }}",
        frame.width(), frame.height(), rate_, name);
    pipe_ = popen(command.c_str(), "w");
    if (!pipe_) fail(file_, "ffmpeg does not start");
  }
  fs::path file_;
  Unfinished unfinished_;
  double rate_;
  BrokenPipesReturn broken_pipes_return_;
  std::FILE* pipe_ = nullptr;
};

}  // namespace

std::unique_ptr<AnimationWriter> make_animation(const fs::path& file, double rate) {
  const std::string ending = file.extension().string();
  if (!(rate > 0.0 && rate <= 50.0))
    throw UserError(fmt::format("--rate {}: an animation has more than 0 and at most 50 frames per second", rate));
  if (ending == ".webp") return std::make_unique<WebpWriter>(file, rate);
  if (ending == ".gif") return std::make_unique<GifWriter>(file, rate);
  if (ending == ".mp4") return std::make_unique<Mp4Writer>(file, rate);
  throw UserError(fmt::format("--animation {}: the name must end in .webp, .gif or .mp4", file.string()));
}

}  // namespace voile::picture
