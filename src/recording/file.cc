#include "recording/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/text.h"

namespace fleetpub::recording {
namespace {

constexpr std::size_t kChunk = std::size_t{256} * 1024;

enum class Push { kNothing, kFlush, kEnd };

Error Trouble(std::string_view what, const std::string& name, int reason) {
  return {ErrorKind::kLedger,
          fmt::format("cannot {} {}: {}", what, base::Printable(name), std::strerror(reason))};
}

}  // namespace

// The base of it writes bytes as they are.
struct OutputFile::Codec {
  Codec(int descriptor, std::string name) : descriptor_(descriptor), name_(std::move(name)) {}
  Codec(const Codec&) = delete;
  Codec& operator=(const Codec&) = delete;
  virtual ~Codec() {
    if (descriptor_ >= 0) close(descriptor_);
  }

  [[nodiscard]] virtual Status Write(std::string_view bytes, Push push) {
    static_cast<void>(push);
    return Store(bytes);
  }

  [[nodiscard]] Status Store(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t count = write(descriptor_, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return Fail(Trouble("write", name_, errno));
      bytes.remove_prefix(static_cast<std::size_t>(count));
      size_ += static_cast<std::uint64_t>(count);
    }
    return {};
  }

  [[nodiscard]] Status Close() {
    if (close(std::exchange(descriptor_, -1)) == 0) return {};
    return Fail(Trouble("write", name_, errno));
  }

  [[nodiscard]] std::uint64_t size() const { return size_; }

 private:
  int descriptor_;
  std::string name_;
  std::uint64_t size_ = 0;
};

namespace {

template <class Codec>
class GzipOutput final : public Codec {
 public:
  GzipOutput(int descriptor, std::string name) : Codec(descriptor, std::move(name)) {
    constexpr int kGzip = 16;  // said to zlib beside the window
    deflateInit2(&stream_, Z_DEFAULT_COMPRESSION, Z_DEFLATED, MAX_WBITS + kGzip, 8,
                 Z_DEFAULT_STRATEGY);
  }
  ~GzipOutput() override { deflateEnd(&stream_); }

  Status Write(std::string_view bytes, Push push) override {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): zlib writes nothing there
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream_.avail_in = static_cast<uInt>(bytes.size());
    const int flush = push == Push::kEnd     ? Z_FINISH
                      : push == Push::kFlush ? Z_SYNC_FLUSH
                                             : Z_NO_FLUSH;
    do {
      stream_.next_out = reinterpret_cast<Bytef*>(buffer_.data());
      stream_.avail_out = static_cast<uInt>(buffer_.size());
      deflate(&stream_, flush);
      const std::size_t made = buffer_.size() - stream_.avail_out;
      if (auto ok = Codec::Store(std::string_view(buffer_.data(), made)); !ok) return ok;
    } while (stream_.avail_out == 0);
    return {};
  }

 private:
  z_stream stream_{};
  std::array<char, 65536> buffer_{};
};

template <class Codec>
class ZstdOutput final : public Codec {
 public:
  using Codec::Codec;
  ~ZstdOutput() override { ZSTD_freeCCtx(context_); }

  Status Write(std::string_view bytes, Push push) override {
    ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
    const ZSTD_EndDirective directive = push == Push::kEnd     ? ZSTD_e_end
                                        : push == Push::kFlush ? ZSTD_e_flush
                                                               : ZSTD_e_continue;
    std::size_t left = 0;
    do {
      ZSTD_outBuffer out{buffer_.data(), buffer_.size(), 0};
      left = ZSTD_compressStream2(context_, &out, &in, directive);
      if (ZSTD_isError(left) != 0) return Fail(ErrorKind::kLedger, ZSTD_getErrorName(left));
      if (auto ok = Codec::Store(std::string_view(buffer_.data(), out.pos)); !ok) return ok;
    } while (in.pos < in.size || (push != Push::kNothing && left != 0));
    return {};
  }

 private:
  ZSTD_CCtx* context_ = ZSTD_createCCtx();
  std::array<char, 65536> buffer_{};
};

}  // namespace

OutputFile::OutputFile(std::unique_ptr<Codec> codec) : codec_(std::move(codec)) {}
OutputFile::OutputFile(OutputFile&&) noexcept = default;
OutputFile& OutputFile::operator=(OutputFile&&) noexcept = default;
OutputFile::~OutputFile() = default;

Result<OutputFile> OutputFile::Create(const std::filesystem::path& path) {
  constexpr mode_t kOwnerOnly = 0600;
  const int descriptor =
      open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, kOwnerOnly);
  if (descriptor < 0 && errno == EEXIST) {
    return Fail(ErrorKind::kLedger, fmt::format("{} is there already, and nothing is overwritten: "
                                                "give another name",
                                                base::Printable(path.string())));
  }
  if (descriptor < 0) return Fail(Trouble("write", path.string(), errno));
  std::unique_ptr<Codec> codec;
  if (path.extension() == ".gz") {
    codec = std::make_unique<GzipOutput<Codec>>(descriptor, path.string());
  } else if (path.extension() == ".zst") {
    codec = std::make_unique<ZstdOutput<Codec>>(descriptor, path.string());
  } else {
    codec = std::make_unique<Codec>(descriptor, path.string());
  }
  return OutputFile(std::move(codec));
}

Status OutputFile::Write(std::string_view lines) { return codec_->Write(lines, Push::kNothing); }
Status OutputFile::Flush() { return codec_->Write({}, Push::kFlush); }
std::uint64_t OutputFile::size() const { return codec_->size(); }

Status OutputFile::Close() {
  if (auto ok = codec_->Write({}, Push::kEnd); !ok) return ok;
  return codec_->Close();
}

// The base of it reads bytes as they are.
struct InputFile::Codec {
  Codec(int descriptor, std::string name) : descriptor_(descriptor), name_(std::move(name)) {}
  Codec(const Codec&) = delete;
  Codec& operator=(const Codec&) = delete;
  virtual ~Codec() {
    if (descriptor_ > STDIN_FILENO) close(descriptor_);
  }

  // Appends some of what the file says to `text`. False: it has ended.
  [[nodiscard]] virtual Result<bool> Read(std::string& text) {
    auto has_input = HasInput();
    if (has_input) text += std::exchange(raw_, {});
    return has_input;
  }
  // Compressed data has an end of its own.
  [[nodiscard]] virtual bool IsWhole() const { return true; }

  // Whether there are bytes of the file still to be read.
  [[nodiscard]] Result<bool> HasInput() {
    if (!raw_.empty() || Load()) return true;
    return trouble_ ? Result<bool>(Fail(*trouble_)) : false;
  }

  // More bytes of the file, behind those that are there already.
  bool Load() {
    std::string chunk(kChunk, '\0');
    ssize_t count = 0;
    do {
      count = read(descriptor_, chunk.data(), chunk.size());
    } while (count < 0 && errno == EINTR);
    if (count < 0) trouble_ = Trouble("read", name_, errno);
    if (count <= 0) return false;
    raw_ += chunk.substr(0, static_cast<std::size_t>(count));
    return true;
  }

  int descriptor_;
  std::string name_;
  std::string raw_;
  std::optional<Error> trouble_;
  // Of Next().
  std::string text_;
  std::size_t next_ = 0;
  std::size_t scanned_ = 0;
  bool ended_ = false;
  bool is_cut_off_ = false;
  bool is_first_ = true;
};

namespace {

// Damaged data ends the file where the damage begins. At the end of data that was cut off
// the decoder may hold text for which there was no room: it comes without further input.
template <class Codec>
class GzipInput final : public Codec {
 public:
  GzipInput(int descriptor, std::string name) : Codec(descriptor, std::move(name)) {
    constexpr int kGzip = 16;
    inflateInit2(&stream_, MAX_WBITS + kGzip);
  }
  ~GzipInput() override { inflateEnd(&stream_); }

  Result<bool> Read(std::string& text) override {
    if (is_damaged_) return false;
    auto has_input = this->HasInput();
    if (!has_input || (!*has_input && is_whole_)) return has_input;
    if (is_whole_ && stream_.total_in > 0) inflateReset(&stream_);  // another member follows
    is_whole_ = false;
    std::string out(kChunk, '\0');
    stream_.next_in = reinterpret_cast<Bytef*>(this->raw_.data());
    stream_.avail_in = static_cast<uInt>(this->raw_.size());
    stream_.next_out = reinterpret_cast<Bytef*>(out.data());
    stream_.avail_out = static_cast<uInt>(out.size());
    const int result = inflate(&stream_, Z_NO_FLUSH);
    is_whole_ = result == Z_STREAM_END;
    is_damaged_ = result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR;
    this->raw_.erase(0, this->raw_.size() - stream_.avail_in);
    const std::size_t made = out.size() - stream_.avail_out;
    text.append(out, 0, made);
    return *has_input || made > 0;
  }
  [[nodiscard]] bool IsWhole() const override { return is_whole_; }

 private:
  z_stream stream_{};
  bool is_whole_ = false;
  bool is_damaged_ = false;
};

template <class Codec>
class ZstdInput final : public Codec {
 public:
  using Codec::Codec;
  ~ZstdInput() override { ZSTD_freeDCtx(context_); }

  Result<bool> Read(std::string& text) override {
    if (is_damaged_) return false;
    auto has_input = this->HasInput();
    if (!has_input || (!*has_input && is_whole_)) return has_input;
    std::string out(kChunk, '\0');
    ZSTD_inBuffer in{this->raw_.data(), this->raw_.size(), 0};
    ZSTD_outBuffer made{out.data(), out.size(), 0};
    const std::size_t left = ZSTD_decompressStream(context_, &made, &in);
    is_damaged_ = ZSTD_isError(left) != 0;
    is_whole_ = left == 0;
    this->raw_.erase(0, in.pos);
    text.append(out, 0, made.pos);
    return *has_input || made.pos > 0;
  }
  [[nodiscard]] bool IsWhole() const override { return is_whole_; }

 private:
  ZSTD_DCtx* context_ = ZSTD_createDCtx();
  bool is_whole_ = false;
  bool is_damaged_ = false;
};

template <class Input, class Codec>
std::unique_ptr<Codec> Become(Codec& plain) {
  auto codec = std::make_unique<Input>(std::exchange(plain.descriptor_, -1), plain.name_);
  codec->raw_ = std::move(plain.raw_);
  return codec;
}

}  // namespace

InputFile::InputFile(std::unique_ptr<Codec> codec) : codec_(std::move(codec)) {}
InputFile::InputFile(InputFile&&) noexcept = default;
InputFile& InputFile::operator=(InputFile&&) noexcept = default;
InputFile::~InputFile() = default;
bool InputFile::is_cut_off() const { return codec_->is_cut_off_; }

Result<InputFile> InputFile::Open(const std::filesystem::path& path) {
  const bool is_input = path == "-";
  const int descriptor = is_input ? STDIN_FILENO : open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return Fail(Trouble("open", path.string(), errno));
  auto plain = std::make_unique<Codec>(descriptor, is_input ? "standard input" : path.string());
  constexpr std::string_view kGzip = "\x1f\x8b";
  constexpr std::string_view kZstd = "\x28\xb5\x2f\xfd";
  while (plain->raw_.size() < kZstd.size() && plain->Load()) {
  }
  if (plain->trouble_) return Fail(*plain->trouble_);
  if (plain->raw_.starts_with(kGzip)) return InputFile(Become<GzipInput<Codec>>(*plain));
  if (plain->raw_.starts_with(kZstd)) return InputFile(Become<ZstdInput<Codec>>(*plain));
  return InputFile(std::move(plain));
}

Result<std::optional<std::string_view>> InputFile::Next() {
  Codec& c = *codec_;
  bool is_too_long = false;
  for (;;) {
    const std::size_t end = c.text_.find('\n', c.scanned_);
    const bool has_line = end != std::string::npos;
    if (!has_line && !c.ended_) {
      is_too_long = is_too_long || c.text_.size() - c.next_ > kLongestLine;
      c.text_.erase(0, is_too_long ? c.text_.size() : c.next_);
      c.next_ = 0;
      c.scanned_ = c.text_.size();
      auto more = c.Read(c.text_);
      if (!more) return Fail(std::move(more.error()));
      if (!*more) {
        c.ended_ = true;
        c.is_cut_off_ = !c.IsWhole() || c.text_.size() > c.next_;
      }
      continue;
    }
    if (!has_line && c.next_ == c.text_.size() && !is_too_long) return std::nullopt;
    const std::size_t stop = has_line ? end : c.text_.size();
    std::string_view line = std::string_view(c.text_).substr(c.next_, stop - c.next_);
    c.next_ = c.scanned_ = has_line ? end + 1 : stop;
    if (is_too_long || line.size() > kLongestLine) {
      return Fail(ErrorKind::kInvalid, fmt::format("{} has a line of more than {} bytes",
                                                   base::Printable(c.name_), kLongestLine));
    }
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (std::exchange(c.is_first_, false)) line = base::WithoutByteOrderMark(line);
    return line;
  }
}

}  // namespace fleetpub::recording
