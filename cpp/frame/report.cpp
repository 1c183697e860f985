#include "frame/report.h"

#include "particles/fields.h"

namespace motes::frame {

using particles::Bytes;
using particles::Reader;

namespace {

template <class T>
T read_new(Reader& in) {
  T value;
  particles::read_fields(in, value);
  return value;
}

}  // namespace

void write(const Report& report, Bytes& out) { particles::write_fields(report, out); }
void write(const Verdict& verdict, Bytes& out) { particles::write_fields(verdict, out); }
void write(const Orders& orders, Bytes& out) { particles::write_fields(orders, out); }
void write(const Planned& planned, Bytes& out) { particles::write_fields(planned, out); }
void write(const Inquiry& inquiry, Bytes& out) { particles::write_fields(inquiry, out); }
void write(const Proposal& proposal, Bytes& out) { particles::write_fields(proposal, out); }

void read(Reader& in, Report& report) { particles::read_fields(in, report); }
Verdict read_verdict(Reader& in) { return read_new<Verdict>(in); }
Orders read_orders(Reader& in) { return read_new<Orders>(in); }
Planned read_planned(Reader& in) { return read_new<Planned>(in); }
Inquiry read_inquiry(Reader& in) { return read_new<Inquiry>(in); }
Proposal read_proposal(Reader& in) { return read_new<Proposal>(in); }

}  // namespace motes::frame
