// These functions are the logarithm and the arc tangent in double precision, which GLSL lacks. They have no branches,
// because software devices would execute both sides of each.
//   Error: 3 ulp of the result, or 3 ulp of 0.1 where a logarithm is smaller; tests/device/double_math_test.cpp.
//   Source: the polynomials of FDLIBM, e_log.c and s_atan.c (Sun Microsystems, 1993).

// Returns ln x for a normal number x > 0.
double logOf(double x) {
  uvec2 bits = unpackDouble2x32(x);
  uint high = bits.y + (0x3FF00000u - 0x3FE6A09Eu);
  double k = double(int(high >> 20) - 1023);
  double f = packDouble2x32(uvec2(bits.x, (high & 0xFFFFFu) + 0x3FE6A09Eu)) - 1.0LF;  // from 2^-1/2 - 1 to 2^1/2 - 1
  double s = f / (2.0LF + f), z = s * s, half_square = 0.5LF * f * f;
  double r = z * (6.666666666666735130e-01LF +
                  z * (3.999999999940941908e-01LF +
                       z * (2.857142874366239149e-01LF +
                            z * (2.222219843214978396e-01LF +
                                 z * (1.818357216161805012e-01LF +
                                      z * (1.531383769920937332e-01LF + z * 1.479819860511658591e-01LF))))));
  return k * 6.93147180369123816490e-01LF -
         ((half_square - (s * (half_square + r) + k * 1.90821492927058770002e-10LF)) - f);
}

// Returns the angle between (x, y) and the x axis, 0 to pi, for y >= 0 and (x, y) other than (0, 0).
double angleOf(double x, double y) {
  double size = abs(x), low = min(y, size), high = max(y, size);
  bool turned = low > 0.41421356237309503LF * high;  // tan(pi/8): beyond it, t is the tangent from the diagonal
  double t = (turned ? low - high : low) / (turned ? low + high : high), z = t * t;
  double r = z * (3.33333333333329318027e-01LF +
                  z * (-1.99999999998764832476e-01LF +
                       z * (1.42857142725034663711e-01LF +
                            z * (-1.11111104054623557880e-01LF +
                                 z * (9.09088713343650656196e-02LF +
                                      z * (-7.69187620504482999495e-02LF +
                                           z * (6.66107313738753120669e-02LF +
                                                z * (-5.83357013379057348645e-02LF +
                                                     z * (4.97687799461593236017e-02LF +
                                                          z * (-3.65315727442169155270e-02LF +
                                                               z * 1.62858201153657823623e-02LF))))))))));
  double angle = (turned ? 0.78539816339744830962LF : 0.0LF) + (t - t * r);
  angle = y > size ? 1.57079632679489661923LF - angle : angle;
  return x < 0.0LF ? 3.14159265358979323846LF - angle : angle;
}
